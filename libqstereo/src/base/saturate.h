/* Sums that are kept within a bound: mostly 2^53 (docs/FORMAT.md, the bound on all numbers). */
#ifndef QS_SATURATE_H
#define QS_SATURATE_H

#include <stdbool.h>
#include <stdint.h>

#include "../../include/qstereo/limits.h"

/* magnitude += x * y, saturated at `most`, which is below 2^62. */
static inline void qs_grow_to(uint64_t *magnitude, uint64_t x, uint64_t y, uint64_t most)
{
    const uint64_t small = UINT32_MAX;
    bool fits = (x <= small && y <= small) || x == 0 ||
                y <= UINT64_MAX / 2 / x; /* mostly without a division */
    uint64_t sum = fits ? *magnitude + (x * y <= most ? x * y : most) : most;
    *magnitude = sum < most ? sum : most;
}

/* The same, saturated above QS_ENERGY_MAX. */
static inline void qs_grow(uint64_t *magnitude, uint64_t x, uint64_t y)
{
    qs_grow_to(magnitude, x, y, (uint64_t)QS_ENERGY_MAX + 1);
}

static inline uint64_t qs_absolute(int64_t value)
{
    return value < 0 ? -(uint64_t)value : (uint64_t)value;
}

/* *sum += value, |value| at most 2^62; beyond 2^60 the sum overflows, and stays far from the ends
 * of an int64_t. */
static inline void qs_add(int64_t *sum, int64_t value, bool *overflow)
{
    *sum += value;
    if (qs_absolute(*sum) > (uint64_t)1 << 60) {
        *overflow = true;
        *sum = 0;
    }
}

#endif
