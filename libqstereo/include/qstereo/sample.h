/* What a sample means: is it feasible, which labelling is it, and what the nearest labelling below it. */
#ifndef QSTEREO_SAMPLE_H
#define QSTEREO_SAMPLE_H

#include "qubo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The number of one-hot groups that do not have exactly one variable at 1: 0 = the sample is feasible. */
uint32_t qs_sample_infeasible(const qs_index *index, const uint8_t *bits);

/* The labelling of a feasible sample.
 *
 * labelling  out: the label index of each site (group)
 * Returns QS_OK, QS_E_INFEASIBLE, or QS_E_UNSUPPORTED (the file does not say what its variables mean). */
QS_MUST_CHECK qs_status qs_sample_decode(const qs_index *index, const uint8_t *bits, uint16_t *labelling);

/* The sample of a labelling: writes ceil(variables / 8) bytes. Returns QS_OK, QS_E_ARGUMENT (a label out of range) or
 * QS_E_UNSUPPORTED. */
QS_MUST_CHECK qs_status qs_sample_encode(const qs_index *index, const uint16_t *labelling, uint8_t *bits);

/* Makes a sample feasible, greedily (docs/MATHS.md): first each group with several variables at 1 keeps the one that costs least beside
 * its neighbours, then each empty group, in order, gets the one that costs least. H never rises with the penalties that
 * QS_PENALTY_LOCAL and QS_PENALTY_PAPER choose, and falls by at least the gap (1 with the paper's) if anything is changed. Of equals
 * the lowest label is taken.
 * Returns the number of groups changed. */
uint32_t qs_sample_repair(const qs_index *index, uint8_t *bits);

#ifdef __cplusplus
}
#endif

#endif
