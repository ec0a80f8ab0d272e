/* Numbers of the command line, read strictly, and exact decimal numbers.
 *
 * The readers of options return an exit status, DONE or BAD_USAGE; they have printed what is wrong
 * and which values are allowed. */
#ifndef NUMBERS_H
#define NUMBERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Reads `count` whole numbers, each at most 2^32 - 1, with `separator` between them. Returns false
 * if the text is anything else. */
bool numbers_read(const char *text, char separator, uint32_t *numbers, size_t count);

/* Reads MIN:MAX, two whole numbers from -(2^31 - 1) to 2^31 - 1, each perhaps with a - before it.
 * Returns false if the text is anything else. */
bool range_read(const char *text, int32_t range[2]);

/* Reads one whole number from least to most, digits only. `option` names it in messages. */
int number_read(const char *option, const char *text, uint32_t least, uint32_t most,
                uint32_t *number);
int number64_read(const char *option, const char *text, uint64_t least, uint64_t most,
                  uint64_t *number);

/* Reads a threshold: a finite decimal number from 0. */
int threshold_read(const char *option, const char *text, double *threshold);

/* Reads any finite decimal number. */
int real_read(const char *option, const char *text, double *number);

/* Reads a percentage from 0: a decimal number, with or without %. */
int percent_read(const char *option, const char *text, double *percent);

/* Reads seconds, a finite decimal number above 0, and returns microseconds. */
int seconds_read(const char *option, const char *text, int64_t *microseconds);

/* The ending of a noun after its number: "" after 1, else "s". */
const char *plural(uint64_t count);

/* Exact decimals: text to a fraction of integers, and integers divided by a scale to text. */

/* In lowest terms. */
typedef struct fraction {
    uint64_t numerator;
    uint32_t denominator;
} fraction;

typedef enum decimal_status {
    DECIMAL_OK,
    DECIMAL_GARBAGE, /* not a decimal number at all */
    DECIMAL_NEGATIVE,
    DECIMAL_TOO_FINE, /* the denominator is above the most */
    DECIMAL_TOO_LARGE /* the numerator is above the most */
} decimal_status;

/* The largest denominator that a caller can ask for. */
#define DECIMAL_DENOMINATOR_MAX 1000000u

/* Reads digits with an optional point and an optional exponent (20, 12.5, .5, 2.5e1), and nothing
 * else.
 *
 * most_numerator    below 2^63
 * most_denominator  up to DECIMAL_DENOMINATOR_MAX
 * read              out: the number, after DECIMAL_OK */
decimal_status decimal_read(const char *text, uint64_t most_numerator, uint32_t most_denominator,
                            fraction *read);

/* Prints why decimal_read refused the argument of an option, and what it `can_be`. Returns
 * BAD_USAGE. */
int decimal_fail(const char *option, const char *text, decimal_status status, const char *can_be);

#define DECIMAL_SIZE 64

/* Writes units / scale. It is exact if the number has a finite decimal, as it has if `scale` came
 * from a decimal number; else it has 17 digits. */
void decimal_write(int64_t units, uint32_t scale, char text[DECIMAL_SIZE]);

/* The gap between an energy and a lower bound, for people. */

#define GAP_SIZE 96

/* Writes "3 (0.0008 %)": the gap in real units, and in percent of the energy if that is not 0. */
void gap_write(int64_t energy, int64_t lower_bound, uint32_t scale, char text[GAP_SIZE]);

/* The gap in percent of the energy. */
double gap_percent(int64_t energy, int64_t lower_bound);

#endif
