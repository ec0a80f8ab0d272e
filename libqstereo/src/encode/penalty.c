#include "penalty.h"

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../problem/pairwise.h"

/* ceil(x * y / divisor) */
static uint64_t share(uint64_t x, uint64_t y, uint64_t divisor)
{
    uint64_t sum = 0;
    qs_grow(&sum, x / divisor, y);
    qs_grow(&sum, 1, (x % divisor * y + divisor - 1) / divisor);
    return sum;
}

/* (tau - 1) + (tau - 2) + ..., at most `count` terms. */
static uint64_t falling(uint64_t tau, uint64_t count)
{
    uint64_t terms = qs_min_u64(count, tau - 1);
    return terms * tau - terms * (terms + 1) / 2;
}

/* The largest sum of a row of the band: that of the label in the middle. */
static uint64_t largest_row(uint64_t tau, uint64_t labels)
{
    return tau == 0 ? 0 : tau + falling(tau, (labels - 1) / 2) + falling(tau, labels / 2);
}

/* b - a of one-hot-sparse, less the gap. */
static uint64_t sparse_bound(qs_penalty penalty, const qs_pairwise *pairwise, uint32_t labels,
                             qs_site_edges edges)
{
    uint64_t tau = qs_band(pairwise, labels), bound = 0;
    bool local = penalty == QS_PENALTY_LOCAL;
    if (pairwise->smoothness == QS_POTTS) {
        return local ? edges.most : share(edges.most, 1, 2);
    }
    if (local) {
        qs_grow(&bound, edges.weights, largest_row(tau, labels));
        return bound;
    }
    return tau > 0 ? share(edges.weights, 6 * tau - 3, 4) : 0;
}

void qs_one_hot_bound(qs_encoding encoding, qs_penalty penalty, const qs_pairwise *pairwise,
                      uint32_t labels, uint64_t gap, qs_site_edges edges, uint64_t *a, uint64_t *b)
{
    *a = gap;
    uint64_t above = gap;
    if (encoding == QS_ONE_HOT) {
        qs_grow(a, 1, edges.most);
    } else {
        qs_grow(&above, 1, sparse_bound(penalty, pairwise, labels, edges));
    }
    *b = *a;
    qs_grow(b, 1, above);
}

uint64_t qs_wall_bound(const qs_pairwise *pairwise, uint32_t labels, uint64_t gap, uint64_t inner,
                       uint64_t weights)
{
    uint64_t kappa = gap, tau = qs_band(pairwise, labels);
    qs_grow(&kappa, 1, inner);
    if (pairwise->smoothness == QS_POTTS) {
        qs_grow(&kappa, 1, weights);
    } else if (!qs_is_linear(pairwise, labels)) {
        qs_grow(&kappa, 1, share(weights, 3 * tau, 2));
    }
    return kappa;
}
