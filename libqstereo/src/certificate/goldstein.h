/* Goldstein's criterion (1994), for any pairwise costs. Let e be a label that is left to a site.
 * Label d is in no optimum if it costs more than e by more than the edges can make up for, whatever
 * labels are left to the neighbours:
 *
 *     cost(d) - cost(e) + sum over edges of min_b [cost of (d, b) - cost of (e, b)] > 0 */
#ifndef QS_GOLDSTEIN_H
#define QS_GOLDSTEIN_H

#include "stated_problem.h"

#define QS_NO_LABEL UINT32_MAX

/* Returns true if label e rules out all labels of a site that are left, and not claimed to stay.
 *
 * claimed  of each label of the problem
 * costs    memory for a number of each of the most labels; out: if above 0, the label is ruled out.
 *          Of labels that stay whatever there was */
bool qs_goldstein_rules_out(const qs_stated *stated, uint32_t site, uint32_t e,
                            const uint8_t *claimed, int64_t *costs);

/* Looks for a label that rules out any of those. It is the cheapest one that is looked at or, with
 * `all`, each in turn.
 *
 * sets  of each label of the problem; out for those of the site: what is left then
 *
 * Returns QS_NO_LABEL if there is none. */
uint32_t qs_goldstein_at(const qs_stated *stated, uint32_t site, const uint8_t *claimed, bool all,
                         uint8_t *sets, int64_t *costs);

#endif
