/* The pairwise cost V, of problems and of models. */
#ifndef QS_PAIRWISE_H
#define QS_PAIRWISE_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"

static inline int64_t qs_truncated(int64_t cost, uint32_t truncation)
{
    return truncation != 0 && cost > truncation ? truncation : cost;
}

/* V(a, b). The table of QS_TABLES is that of the edge. */
static inline int64_t qs_pairwise_value(const qs_pairwise *pairwise, uint32_t labels, uint32_t a,
                                        uint32_t b)
{
    int64_t apart = a < b ? b - a : a - b;
    switch (pairwise->smoothness) {
    case QS_POTTS: return a != b;
    case QS_TRUNCATED_LINEAR: return qs_truncated(apart, pairwise->truncation);
    case QS_TRUNCATED_QUADRATIC: return qs_truncated(apart * apart, pairwise->truncation);
    case QS_TABLE:
    case QS_TABLES: break;
    }
    return pairwise->table[(size_t)a * labels + b];
}

/* tau of V = min(|a - b|, tau), Potts or truncated linear; at most labels - 1 for the latter. */
static inline uint32_t qs_band(const qs_pairwise *pairwise, uint32_t labels)
{
    if (pairwise->smoothness == QS_POTTS) {
        return 1;
    }
    bool truncates = pairwise->truncation != 0 && pairwise->truncation < labels;
    return truncates ? pairwise->truncation : labels - 1;
}

/* Returns true if V is |a - b| for every two labels. */
static inline bool qs_is_linear(const qs_pairwise *pairwise, uint32_t labels)
{
    return pairwise->smoothness == QS_TRUNCATED_LINEAR && qs_band(pairwise, labels) == labels - 1;
}

/* One-hot-sparse writes V as tau - (tau - |a - b|)^+ and couples the part in brackets, here of two
 * labels `apart` from each other. */
static inline int64_t qs_band_entry(int64_t tau, int64_t apart)
{
    int64_t distance = apart < 0 ? -apart : apart;
    return distance < tau ? tau - distance : 0;
}

#endif
