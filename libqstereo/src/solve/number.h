/* The numbers that messages, flows and heights are computed in.
 *
 * They have 32 bits, which is fast and enough for most costs. Where costs are too large for that,
 * the same code computes in 64 bits, which is enough for all that a model may have: a file x.c that
 * works on qs_number is compiled once more by x_64.c, with other names (in_64_bits.h). */
#ifndef QS_NUMBER_H
#define QS_NUMBER_H

#include <stdint.h>

#ifndef QS_BITS
#define QS_BITS 32
#endif

#if QS_BITS == 64
typedef int64_t qs_number;
typedef uint64_t qs_natural;
#define QS_NUMBER_MAX  INT64_MAX
#define QS_NATURAL_MAX UINT64_MAX
#else
typedef int32_t qs_number;
typedef uint32_t qs_natural;
#define QS_NUMBER_MAX  INT32_MAX
#define QS_NATURAL_MAX UINT32_MAX
#endif

/* Costs are too large for 32 bits: a call of the same function in 64 bits. There it is what is left
 * to say: there are no larger numbers. */
#if QS_BITS == 64
#define QS_IN_64_BITS(refusal, function, ...) (refusal)
#else
#define QS_IN_64_BITS(refusal, function, ...) function##_64(__VA_ARGS__)
#endif

static inline qs_number qs_min_number(qs_number a, qs_number b)
{
    return a < b ? a : b;
}

static inline qs_number qs_max_number(qs_number a, qs_number b)
{
    return a > b ? a : b;
}

/* The least of `count` numbers, one or more. */
static inline qs_number qs_least(const qs_number *numbers, uint32_t count)
{
    qs_number least = numbers[0];
    for (uint32_t i = 1; i < count; i++) {
        least = qs_min_number(least, numbers[i]);
    }
    return least;
}

/* Where the least of `count` numbers is; of equals the first. */
static inline uint32_t qs_least_at(const qs_number *numbers, uint32_t count)
{
    uint32_t first = 0;
    for (uint32_t i = 1; i < count; i++) {
        first = numbers[i] < numbers[first] ? i : first;
    }
    return first;
}

#endif
