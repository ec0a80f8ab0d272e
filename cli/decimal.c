#include "decimal.h"

#include <stdbool.h>
#include <stdio.h>

enum { DIGITS_MAX = 64, EXPONENT_MAX = 100000 };

/* 0.d1 d2 ... dn x 10^point, d1 and dn not 0; no digits = 0. */
typedef struct digits {
    char digit[DIGITS_MAX];
    int count;
    int point;
    int zeros; /* seen since the last digit kept */
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

/* Reads the digits before and after the point. Returns the end, NULL = there is no digit. */
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
        /* The first digit that is not 0 sets the point: each digit before the decimal point moves
         * it up, each 0 between the decimal point and that digit down. */
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

/* The digits behind the point as a fraction in lowest terms. A decimal of n places has a
 * denominator of at least 2^n (its last digit is not 0), so 19 places, which 64 bits hold, are all
 * that DECIMAL_DENOMINATOR_MAX lets through. */
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

/* 32 places write every finite decimal whose denominator has 32 bits. */
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
