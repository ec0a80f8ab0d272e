/* The smaller and the larger of two numbers, for each type that the library computes in. */
#ifndef QS_MINMAX_H
#define QS_MINMAX_H

#include <stdint.h>

#define QS_MINMAX(suffix, type)                                                                    \
    static inline type qs_min_##suffix(type a, type b)                                             \
    {                                                                                              \
        return a < b ? a : b;                                                                      \
    }                                                                                              \
    static inline type qs_max_##suffix(type a, type b)                                             \
    {                                                                                              \
        return a > b ? a : b;                                                                      \
    }

QS_MINMAX(i32, int32_t)
QS_MINMAX(u32, uint32_t)
QS_MINMAX(i64, int64_t)
QS_MINMAX(u64, uint64_t)

#undef QS_MINMAX

/* Where the least of `count` costs is; of equals the first. */
static inline uint32_t qs_first_least(const int32_t *costs, uint32_t count)
{
    uint32_t first = 0;
    for (uint32_t i = 1; i < count; i++) {
        first = costs[i] < costs[first] ? i : first;
    }
    return first;
}

#endif
