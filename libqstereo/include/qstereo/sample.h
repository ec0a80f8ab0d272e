/* What a sample means: whether it is feasible, which labelling it is, and how
 * it is made feasible. */
#ifndef QSTEREO_SAMPLE_H
#define QSTEREO_SAMPLE_H

#include "qubo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How much of a sample is not a labelling. 0 = the sample is feasible.
 *
 * In a file with labels this is the number of undecided sites whose variables
 * stand for no label, and of terminals, sources and sinks that do not have
 * their own value (coding.h, qs_site_code and qs_auxiliaries). The variables of
 * arcs do not count. In a file without labels it is the number of groups with a
 * penalty that do not have exactly one variable at 1. */
uint32_t qs_sample_infeasible(const qs_index *index, const uint8_t *bits);

/* The labelling of a feasible sample.
 *
 * labelling  out: the label of each of qubo->labels.sites, fixed ones too
 *
 * Returns
 *   QS_OK
 *   QS_E_INFEASIBLE   the sample is not a labelling
 *   QS_E_UNSUPPORTED  the file does not say what its variables mean */
QS_MUST_CHECK qs_status qs_sample_decode(const qs_index *index,
                                         const uint8_t *bits,
                                         uint16_t *labelling);

/* The sample of a labelling. Variables of arcs get the values that cost least.
 *
 * bits  out: ceil(variables / 8) bytes
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT     a label that does not exist, or is not left to its site
 *   QS_E_UNSUPPORTED  the file does not say what its variables mean */
QS_MUST_CHECK qs_status qs_sample_encode(const qs_index *index,
                                         const uint16_t *labelling,
                                         uint8_t *bits);

/* What truncation took from the costs of a labelling of all sites: its energy F
 * is H of its sample plus this. 0 where nothing was truncated. Labels that are
 * not left to their sites count as 0. */
int64_t qs_sample_trimmed(const qs_qubo *qubo, const uint16_t *labelling);

/* Bytes of workspace for qs_sample_repair. */
size_t qs_repair_workspace(const qs_index *index);

/* Makes a sample feasible in the way that the proof for its encoding does
 * (docs/MATHS.md). With a penalty that is proven (all but QS_PENALTY_GIVEN) H
 * never rises, and if the sample is infeasible H falls by at least the gap (by
 * 1 with the paper's alpha). Sites that have a label keep it, unless a source
 * or a sink is wrong.
 *
 * qs_encoding_repair says which way is taken:
 *   QS_REPAIR_BY_FLIPS        First each group with several variables at 1
 *                             keeps the one that costs least beside its
 *                             neighbours. Then each group without one, in
 *                             order, gets the one that costs least. Of equals
 *                             the lowest label.
 *   QS_REPAIR_BY_LABEL_ORDER  An order of all labels is chosen, label by label,
 *                             such that the expected cost of the rest of the
 *                             order is least. Each site takes the first of its
 *                             candidates in it.
 *   QS_REPAIR_SITE_BY_SITE    Each site in turn takes the candidate that is
 *                             cheapest beside the expected labels of its
 *                             neighbours.
 *   QS_REPAIR_BY_THRESHOLDS   The wrong steps of walls or chains are shifted
 *                             until they meet right ones and vanish. For that a
 *                             domain wall of linear costs has a coupling for
 *                             every edge between undecided sites, also where
 *                             its block is all 0.
 *   QS_REPAIR_BY_CHOICE       Every site takes its first candidate, or every
 *                             site its last; or the label that has as many
 *                             ones; or site by site as above. What costs
 *                             least.
 *
 * workspace  qs_repair_workspace bytes, aligned for any type
 * repaired   out, may be NULL: what qs_sample_infeasible was before
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT   a null pointer
 *   QS_E_WORKSPACE  the workspace is too small */
QS_MUST_CHECK qs_status qs_sample_repair(const qs_index *index, uint8_t *bits,
                                         void *workspace, size_t workspace_size,
                                         uint32_t *repaired);

#ifdef __cplusplus
}
#endif

#endif
