/* The penalties that docs/MATHS.md proves sufficient. All sums are saturated above QS_ENERGY_MAX.
 */
#ifndef QS_PENALTY_H
#define QS_PENALTY_H

#include <stdbool.h>

#include "../../include/qstereo/coding.h"

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
