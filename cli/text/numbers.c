#include "text/numbers.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"

/* Returns the end of the digits; NULL if there are none, or if the number is above `most`. */
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

bool range_read(const char *text, int32_t range[2])
{
    for (int i = 0; i < 2; i++) {
        bool negative = *text == '-';
        uint64_t number;
        text = read_one(text + negative, INT32_MAX, &number);
        if (text == NULL || *text != (i == 0 ? ':' : '\0')) {
            return false;
        }
        range[i] = negative ? -(int32_t)number : (int32_t)number;
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
    return fail_usage("%s %s is not a whole number from %" PRIu64 " to %" PRIu64, option, text,
                      least, most);
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

/* Reads a finite decimal number. */
static bool read_real(const char *text, double *number)
{
    char *end;
    /* strtod alone would also read blanks, hexadecimals, inf and nan. */
    if (text[strspn(text, "0123456789.eE+-")] != '\0') {
        return false;
    }
    *number = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*number);
}

int threshold_read(const char *option, const char *text, double *threshold)
{
    return read_real(text, threshold) && *threshold >= 0
               ? DONE
               : fail_usage("%s %s is not a number from 0", option, text);
}

int real_read(const char *option, const char *text, double *number)
{
    return read_real(text, number) ? DONE : fail_usage("%s %s is not a number", option, text);
}

int percent_read(const char *option, const char *text, double *percent)
{
    char number[32];
    size_t length = strlen(text);
    length -= length > 0 && text[length - 1] == '%';
    (void)snprintf(number, sizeof number, "%.*s", (int)length, text);
    return length < sizeof number && read_real(number, percent) && *percent >= 0
               ? DONE
               : fail_usage("%s %s is not a percentage from 0, such as 0.1%%", option, text);
}

int seconds_read(const char *option, const char *text, int64_t *microseconds)
{
    double seconds;
    if (!read_real(text, &seconds) || seconds <= 0) {
        return fail_usage("%s %s is not a number of seconds above 0", option, text);
    }
    /* Rounded up, because 0 would mean no limit. 2^52 microseconds are more than a century. */
    *microseconds = (int64_t)ceil(fmin(seconds * 1e6, 0x1p52));
    return DONE;
}

int decimal_fail(const char *option, const char *text, decimal_status status, const char *can_be)
{
    const char *why = status == DECIMAL_GARBAGE     ? "not a decimal number"
                      : status == DECIMAL_NEGATIVE  ? "negative"
                      : status == DECIMAL_TOO_LARGE ? "too large"
                                                    : "too fine";
    return fail_usage("%s %s is %s; it can be %s", option, text, why, can_be);
}

const char *plural(uint64_t count)
{
    return count == 1 ? "" : "s";
}

enum { DIGITS_MAX = 64, EXPONENT_MAX = 100000 };

/* The number 0.d1d2...dn x 10^point. d1 and dn are not 0; the number 0 has no digits. */
typedef struct digits {
    char digit[DIGITS_MAX];
    int count;
    int point;
    int zeros; /* read since the last digit that was kept */
    bool cut; /* there were more than DIGITS_MAX */
} digits;

static void keep_digit(digits *number, char digit)
{
    if (digit == '0') {
        number->zeros += number->count > 0;
        return;
    }
    for (; number->zeros > 0 && number->count < DIGITS_MAX; number->zeros--) {
        number->digit[number->count++] = 0;
    }
    number->zeros = 0;
    if (number->count == DIGITS_MAX) {
        number->cut = true;
    } else {
        number->digit[number->count++] = (char)(digit - '0');
    }
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Reads the digits before and after the point. Returns their end, NULL if there are none. */
static const char *read_digits(const char *at, digits *number)
{
    bool any = false, after_point = false;
    for (; is_digit(*at) || (*at == '.' && !after_point); at++) {
        if (*at == '.') {
            after_point = true;
            continue;
        }
        any = true;
        keep_digit(number, *at);
        /* `point` counts from the first digit that is not 0: each digit from there to the decimal
         * point moves it up, and each 0 between the decimal point and that digit moves it down. */
        if (!after_point && number->count > 0 && number->point < EXPONENT_MAX) {
            number->point++;
        }
        if (after_point && number->count == 0 && number->point > -EXPONENT_MAX) {
            number->point--;
        }
    }
    return any ? at : NULL;
}

static const char *read_exponent(const char *at, digits *number)
{
    int exponent = 0;
    if (*at != 'e' && *at != 'E') {
        return at;
    }
    at++;
    bool down = *at == '-';
    at += *at == '-' || *at == '+';
    if (!is_digit(*at)) {
        return NULL;
    }
    for (; is_digit(*at); at++) {
        if (exponent < EXPONENT_MAX) {
            exponent = exponent * 10 + (*at - '0');
        }
    }
    number->point += down ? -exponent : exponent;
    return at;
}

static uint64_t common_divisor(uint64_t a, uint64_t b)
{
    while (b != 0) {
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* The digits after the point as a fraction in lowest terms. A decimal of n places has a denominator
 * of at least 2^n, because its last digit is not 0. So no more than 19 places, which fit 64 bits,
 * can stay below DECIMAL_DENOMINATOR_MAX. */
static bool read_places(const digits *number, uint32_t most, fraction *read)
{
    uint64_t numerator = 0, denominator = 1;
    int places = number->count - number->point;
    if (places > 19) {
        return false;
    }
    for (int i = number->count - places; i < number->count; i++) {
        numerator = numerator * 10 + (uint64_t)(i >= 0 ? number->digit[i] : 0);
        denominator *= 10;
    }
    uint64_t divisor = common_divisor(denominator, numerator);
    if (denominator / divisor > most) {
        return false;
    }
    *read = (fraction){numerator / divisor, (uint32_t)(denominator / divisor)};
    return true;
}

static decimal_status to_fraction(const digits *number, uint64_t most_numerator,
                                  uint32_t most_denominator, fraction *read)
{
    fraction places = {0, 1};
    uint64_t whole = 0;
    if (number->count == 0) {
        *read = places;
        return DECIMAL_OK;
    }
    for (int i = 0; i < number->point; i++) {
        whole = whole * 10 + (uint64_t)(i < number->count ? number->digit[i] : 0);
        if (whole > most_numerator) {
            return DECIMAL_TOO_LARGE;
        }
    }
    if (number->cut || !read_places(number, most_denominator, &places)) {
        return DECIMAL_TOO_FINE;
    }
    if (places.numerator > most_numerator ||
        whole > (most_numerator - places.numerator) / places.denominator) {
        return DECIMAL_TOO_LARGE;
    }
    *read = (fraction){whole * places.denominator + places.numerator, places.denominator};
    return DECIMAL_OK;
}

decimal_status decimal_read(const char *text, uint64_t most_numerator, uint32_t most_denominator,
                            fraction *read)
{
    digits number = {{0}, 0, 0, 0, false};
    bool negative = *text == '-';
    const char *end = read_digits(text + (negative || *text == '+'), &number);
    if (end != NULL) {
        end = read_exponent(end, &number);
    }
    if (end == NULL || *end != '\0') {
        return DECIMAL_GARBAGE;
    }
    if (negative) {
        return DECIMAL_NEGATIVE;
    }
    return to_fraction(&number, most_numerator, most_denominator, read);
}

/* 32 places are enough for every finite decimal whose denominator has 32 bits. */
void decimal_write(int64_t units, uint32_t scale, char text[DECIMAL_SIZE])
{
    uint64_t size = units < 0 ? 0 - (uint64_t)units : (uint64_t)units;
    uint64_t rest = size % scale;
    int used = snprintf(text, DECIMAL_SIZE, "%s%llu", units < 0 ? "-" : "",
                        (unsigned long long)(size / scale));
    if (rest == 0) {
        return;
    }
    text[used++] = '.';
    for (int places = 0; rest != 0 && places < 32; places++) {
        rest *= 10;
        text[used++] = (char)('0' + rest / scale);
        rest %= scale;
    }
    text[used] = '\0';
    if (rest != 0) {
        (void)snprintf(text, DECIMAL_SIZE, "%.17g", (double)units / scale);
    }
}

double gap_percent(int64_t energy, int64_t lower_bound)
{
    return energy == lower_bound ? 0
                                 : 100.0 * (double)(energy - lower_bound) / fabs((double)energy);
}

void gap_write(int64_t energy, int64_t lower_bound, uint32_t scale, char text[GAP_SIZE])
{
    char gap[DECIMAL_SIZE];
    decimal_write(energy - lower_bound, scale, gap);
    if (energy != 0) {
        (void)snprintf(text, GAP_SIZE, "%s (%.4f %%)", gap, gap_percent(energy, lower_bound));
    } else {
        (void)snprintf(text, GAP_SIZE, "%s", gap);
    }
}
