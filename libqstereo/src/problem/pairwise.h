/* V(a, b), of problems and of models. */
#ifndef QS_PAIRWISE_H
#define QS_PAIRWISE_H

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

#endif
