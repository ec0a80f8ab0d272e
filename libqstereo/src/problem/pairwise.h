/* V(a, b), of problems and of models. */
#ifndef QS_PAIRWISE_H
#define QS_PAIRWISE_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"

static inline int64_t qs_truncated(int64_t cost, uint32_t truncation)
{
    return truncation != 0 && cost > truncation ? truncation : cost;
}

static inline int64_t qs_pairwise_value(const qs_pairwise *pairwise, uint32_t labels, uint32_t a,
                                        uint32_t b)
{
    int64_t apart = a < b ? b - a : a - b;
    switch (pairwise->smoothness) {
    case QS_POTTS: return a != b;
    case QS_TRUNCATED_LINEAR: return qs_truncated(apart, pairwise->truncation);
    case QS_TRUNCATED_QUADRATIC: return qs_truncated(apart * apart, pairwise->truncation);
    case QS_TABLE: break;
    }
    return pairwise->table[(size_t)a * labels + b];
}

/* The pairwise cost as V = min(|a - b|, tau). Potts is tau = 1; of a linear cost tau is at most
 * labels - 1, which truncates nothing. Of Potts and linear costs only. */
uint32_t qs_band(const qs_pairwise *pairwise, uint32_t labels);

/* Returns true if V is |a - b| of any two labels: linear, and truncated nowhere. */
bool qs_is_linear(const qs_pairwise *pairwise, uint32_t labels);

/* V = tau - qs_band_entry, where `apart` is a - b: the entry is 0 of labels that are tau or more
 * apart. one-hot-sparse couples only the labels whose entry is not 0. */
static inline int64_t qs_band_entry(int64_t tau, int64_t apart)
{
    int64_t distance = apart < 0 ? -apart : apart;
    return distance < tau ? tau - distance : 0;
}

#endif
