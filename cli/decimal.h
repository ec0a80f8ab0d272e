/* Decimal numbers without rounding: text to a fraction of integers, and integers over a scale to
 * text. */
#ifndef DECIMAL_H
#define DECIMAL_H

#include <stdint.h>

/* In lowest terms. */
typedef struct fraction {
    uint64_t numerator;
    uint32_t denominator;
} fraction;

typedef enum decimal_status {
    DECIMAL_OK,
    DECIMAL_GARBAGE, /* not a decimal number at all */
    DECIMAL_NEGATIVE,
    DECIMAL_TOO_FINE, /* its denominator is above the most */
    DECIMAL_TOO_LARGE /* its numerator is above the most */
} decimal_status;

/* No denominator above this can be asked for. */
#define DECIMAL_DENOMINATOR_MAX 1000000u

/* Reads digits with an optional point and an optional exponent (20, 12.5, .5, 2.5e1) and nothing
 * else. most_numerator  below 2^63; most_denominator  up to DECIMAL_DENOMINATOR_MAX; read  out */
decimal_status decimal_read(const char *text, uint64_t most_numerator, uint32_t most_denominator,
                            fraction *read);

#define DECIMAL_SIZE 64

/* Writes units / scale: exactly where it is a finite decimal, as it is where `scale` came from a
 * decimal number; else to 17 digits. */
void decimal_write(int64_t units, uint32_t scale, char text[DECIMAL_SIZE]);

#endif
