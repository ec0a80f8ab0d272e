/* Sums that do not leave a bound, which is mostly 2^53: the bound of docs/FORMAT.md on the absolute
 * values of all numbers. */
#ifndef QS_SATURATE_H
#define QS_SATURATE_H

#include <stdbool.h>
#include <stdint.h>

#include "../../include/qstereo/limits.h"
#include "minmax.h"

/* magnitude += x * y, but at most `most`, which is below 2^62. */
static inline void qs_grow_to(uint64_t *magnitude, uint64_t x, uint64_t y, uint64_t most)
{
    const uint64_t small = UINT32_MAX;
    /* Mostly without a division. */
    bool fits = (x <= small && y <= small) || x == 0 || y <= UINT64_MAX / 2 / x;
    uint64_t sum = fits ? *magnitude + qs_min_u64(x * y, most) : most;
    *magnitude = qs_min_u64(sum, most);
}

/* The same with a bound of QS_ENERGY_MAX + 1: a sum that is too large stays too large. */
static inline void qs_grow(uint64_t *magnitude, uint64_t x, uint64_t y)
{
    qs_grow_to(magnitude, x, y, (uint64_t)QS_ENERGY_MAX + 1);
}

static inline uint64_t qs_absolute(int64_t value)
{
    return value < 0 ? -(uint64_t)value : (uint64_t)value;
}

/* *sum += value, with |value| at most 2^62. Where the sum leaves +-2^60, *overflow becomes true and
 * the sum starts again from 0, so that it never leaves an int64_t. */
static inline void qs_add(int64_t *sum, int64_t value, bool *overflow)
{
    *sum += value;
    if (qs_absolute(*sum) > (uint64_t)1 << 60) {
        *overflow = true;
        *sum = 0;
    }
}

#endif
