/* What a sample means: is it feasible, which labelling is it, and what the
 * nearest labelling below it. */
#ifndef QSTEREO_SAMPLE_H
#define QSTEREO_SAMPLE_H

#include "qubo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How much of a sample is no labelling: the number of open sites whose
 * variables are none of those that docs/FORMAT.md gives a label, and of
 * terminals, sources and sinks that have not their own value. The variables of
 * arcs do not count. In a file without labels: the groups with a penalty that
 * do not have exactly one variable at 1. 0 = the sample is feasible. */
uint32_t qs_sample_infeasible(const qs_index *index, const uint8_t *bits);

/* The labelling of a feasible sample.
 *
 * labelling  out: the label index of each of qubo->labels.sites, fixed ones too
 * Returns QS_OK, QS_E_INFEASIBLE, or QS_E_UNSUPPORTED (the file does not say
 * what its variables mean). */
QS_MUST_CHECK qs_status qs_sample_decode(const qs_index *index,
                                         const uint8_t *bits,
                                         uint16_t *labelling);

/* The sample of a labelling: writes ceil(variables / 8) bytes. The variables of
 * arcs get what is cheapest. Returns QS_OK, QS_E_ARGUMENT (a label out of
 * range, or one that is not left to its site) or QS_E_UNSUPPORTED. */
QS_MUST_CHECK qs_status qs_sample_encode(const qs_index *index,
                                         const uint16_t *labelling,
                                         uint8_t *bits);

/* What truncating the costs has taken from a labelling of all sites (labels
 * left): its energy F is H of its sample plus this. 0 where nothing was
 * truncated. */
int64_t qs_sample_trimmed(const qs_qubo *qubo, const uint16_t *labelling);

/* Bytes of workspace for qs_sample_repair. */
size_t qs_repair_workspace(const qs_index *index);

/* Makes a sample feasible, as the encoding's proof does (docs/MATHS.md). H
 * never rises with the penalties that are proven (all but QS_PENALTY_GIVEN),
 * and falls by at least the gap (1 with the paper's) if the sample is
 * infeasible. Sites that have a label keep it, but where a source or a sink is
 * wrong.
 *
 * one-hot, multiway-cut, one-hot-sparse but for QS_PENALTY_MINIMAL: first each
 * group with several variables at 1 keeps the one that costs least beside its
 * neighbours, then each empty group, in order, gets the one that costs least;
 * of equals the lowest label. Multiway-cut: then the terminals get their own.
 * Potts in one-hot-sparse, minimal, and in domain-wall: one order of all labels
 * is chosen, label by label, such that what is expected of the rest of the
 * order is least; each site takes the first of its candidates. Truncated linear
 * there: each site in turn takes the candidate that is cheapest beside what is
 * expected of its neighbours. Linear in domain-wall and the cuts: the wrong
 * steps are moved towards each other, or away, until they vanish; for that a
 * domain-wall of linear costs has a coupling for every edge between open sites,
 * also where its block is all 0.
 *
 * workspace  qs_repair_workspace, aligned for any type
 * repaired   out, may be NULL: what qs_sample_infeasible was
 * Returns QS_OK, QS_E_ARGUMENT or QS_E_WORKSPACE. */
QS_MUST_CHECK qs_status qs_sample_repair(const qs_index *index, uint8_t *bits,
                                         void *workspace, size_t workspace_size,
                                         uint32_t *repaired);

#ifdef __cplusplus
}
#endif

#endif
