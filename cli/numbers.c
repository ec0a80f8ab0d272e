#include "numbers.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "messages.h"

/* Returns the end of the digits; NULL = there are none, or the number is above `most`. */
static const char *read_one(const char *at, uint64_t most, uint64_t *number)
{
    uint64_t value = 0;
    if (*at < '0' || *at > '9') {
        return NULL;
    }
    for (; *at >= '0' && *at <= '9'; at++) {
        uint64_t digit = (uint64_t)(*at - '0');
        if (digit > most || value > (most - digit) / 10) {
            return NULL;
        }
        value = value * 10 + digit;
    }
    *number = value;
    return at;
}

bool numbers_read(const char *text, char separator, uint32_t *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t number;
        text = read_one(text, UINT32_MAX, &number);
        if (text == NULL || *text != (i + 1 < count ? separator : '\0')) {
            return false;
        }
        numbers[i] = (uint32_t)number;
        text++;
    }
    return true;
}

int number64_read(const char *option, const char *text, uint64_t least, uint64_t most,
                  uint64_t *number)
{
    const char *end = read_one(text, most, number);
    if (end != NULL && *end == '\0' && *number >= least) {
        return DONE;
    }
    return fail_usage("%s %s: not a whole number from %" PRIu64 " to %" PRIu64, option, text, least,
                      most);
}

int number_read(const char *option, const char *text, uint32_t least, uint32_t most,
                uint32_t *number)
{
    uint64_t read = 0;
    int status = number64_read(option, text, least, most, &read);
    if (status == DONE) {
        *number = (uint32_t)read;
    }
    return status;
}

/* A finite decimal number, not negative. */
static bool read_real(const char *text, double *number)
{
    char *end;
    /* strtod alone would take blanks, hexadecimals, inf and nan as well. */
    if (text[strspn(text, "0123456789.eE+-")] != '\0') {
        return false;
    }
    *number = strtod(text, &end);
    return end != text && *end == '\0' && *number >= 0 && isfinite(*number);
}

int threshold_read(const char *option, const char *text, double *threshold)
{
    return read_real(text, threshold) ? DONE
                                      : fail_usage("%s %s: not a number from 0", option, text);
}

int seconds_read(const char *option, const char *text, int64_t *microseconds)
{
    double seconds;
    if (!read_real(text, &seconds) || seconds <= 0) {
        return fail_usage("%s %s: not a number of seconds above 0", option, text);
    }
    /* Never rounded to 0, which would be no time at all; over 2^52 microseconds is a century. */
    *microseconds = (int64_t)ceil(fmin(seconds * 1e6, 0x1p52));
    return DONE;
}

int decimal_fail(const char *option, const char *text, decimal_status status, const char *can_be)
{
    const char *why = status == DECIMAL_GARBAGE     ? "not a decimal number"
                      : status == DECIMAL_NEGATIVE  ? "negative"
                      : status == DECIMAL_TOO_LARGE ? "too large"
                                                    : "too fine";
    return fail_usage("%s %s: %s; it can be %s", option, text, why, can_be);
}

const char *plural(uint64_t count)
{
    return count == 1 ? "" : "s";
}
