/* The penalties that docs/MATHS.md proves sufficient. All sums are saturated above QS_ENERGY_MAX.
 */
#ifndef QS_PENALTY_H
#define QS_PENALTY_H

#include <stdbool.h>

#include "../../include/qstereo/encode.h"

/* tau of V = min(|a - b|, tau), Potts or truncated linear; at most labels - 1 for the latter. */
uint32_t qs_band(const qs_pairwise *pairwise, uint32_t labels);

/* Whether V is |a - b|, never cut. */
bool qs_is_linear(const qs_pairwise *pairwise, uint32_t labels);

/* What of V = tau - (tau - |a - b|)^+ one-hot-sparse couples: the part in brackets. */
static inline int64_t qs_band_entry(int64_t tau, int64_t apart)
{
    int64_t distance = apart < 0 ? -apart : apart;
    return distance < tau ? tau - distance : 0;
}

/* Whether one-hot or one-hot-sparse holds a pairwise cost with that penalty. The paper's alpha does
 * not hold the band of a linear cost: two neighbours with the same two adjacent labels each gain
 * more than it asks. */
bool qs_one_hot_holds(qs_encoding encoding, qs_penalty penalty, const qs_pairwise *pairwise);

/* What a site's edges can cost. */
typedef struct qs_site_edges {
    uint64_t weights; /* the sum of their weights */
    uint64_t most; /* max_d sum_q weight_pq max_e V(d, e) */
} qs_site_edges;

/* a and b of a site in the one-hot encodings, penalty local or minimal. */
void qs_one_hot_bound(qs_encoding encoding, qs_penalty penalty, const qs_pairwise *pairwise,
                      uint32_t labels, uint64_t gap, qs_site_edges edges, uint64_t *a, uint64_t *b);

/* kappa of a domain wall.
 *
 * inner  the largest (shifted) cost of a label that is neither the first nor the last of the site's
 */
uint64_t qs_wall_bound(const qs_pairwise *pairwise, uint32_t labels, uint64_t gap, uint64_t inner,
                       uint64_t weights);

#endif
