/* Sums of fractions, each rounded down to a multiple of 2^-46: the value is whole + part * 2^-46,
 * with 0 <= part < 2^46. */
#ifndef QS_FRACTION_H
#define QS_FRACTION_H

#include <stdbool.h>
#include <stdint.h>

enum { QS_FRACTION_BITS = 46 };

typedef struct qs_fraction {
    int64_t whole, part;
} qs_fraction;

static inline qs_fraction qs_plus(qs_fraction a, qs_fraction b)
{
    int64_t part = a.part + b.part, carry = part >> QS_FRACTION_BITS;
    return (qs_fraction){a.whole + b.whole + carry,
                         part - carry * ((int64_t)1 << QS_FRACTION_BITS)};
}

static inline qs_fraction qs_minus(qs_fraction a, qs_fraction b)
{
    bool borrow = a.part < b.part;
    return (qs_fraction){a.whole - b.whole - borrow,
                         a.part - b.part + ((int64_t)borrow << QS_FRACTION_BITS)};
}

static inline bool qs_less(qs_fraction a, qs_fraction b)
{
    return a.whole < b.whole || (a.whole == b.whole && a.part < b.part);
}

/* value * some / all, rounded down, with 0 <= some <= all < 2^17. */
static inline qs_fraction qs_share(int64_t value, int64_t some, int64_t all)
{
    int64_t whole = value / all, rest = value % all;
    if (rest < 0) {
        whole--;
        rest += all;
    }
    rest *= some;
    return (qs_fraction){whole * some + rest / all, (rest % all << QS_FRACTION_BITS) / all};
}

#endif
