/* Numbers of the command line, read strictly: whole ones are digits and nothing else. */
#ifndef NUMBERS_H
#define NUMBERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "decimal.h"

/* Reads `count` whole numbers of at most 2^32 - 1 with `separator` between them. */
bool numbers_read(const char *text, char separator, uint32_t *numbers, size_t count);

/* One number of least .. most; `option` names it in the message. Returns DONE or BAD_USAGE. */
int number_read(const char *option, const char *text, uint32_t least, uint32_t most,
                uint32_t *number);
int number64_read(const char *option, const char *text, uint64_t least, uint64_t most,
                  uint64_t *number);

/* A threshold: a finite decimal number, not negative. Returns DONE or BAD_USAGE. */
int threshold_read(const char *option, const char *text, double *threshold);

/* Seconds: a finite decimal number above 0, in microseconds. Returns DONE or BAD_USAGE. */
int seconds_read(const char *option, const char *text, int64_t *microseconds);

/* What a noun has behind its number: nothing for 1, else an s. */
const char *plural(uint64_t count);

/* Says why decimal_read refused the argument of an option, and what it `can_be`. Returns BAD_USAGE.
 */
int decimal_fail(const char *option, const char *text, decimal_status status, const char *can_be);

#endif
