#include "numbers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "messages.h"

/* Returns the end of the digits; NULL = there are none, or too many. */
static const char *read_one(const char *at, uint32_t *number)
{
    uint64_t value = 0;
    if (*at < '0' || *at > '9') {
        return NULL;
    }
    for (; *at >= '0' && *at <= '9'; at++) {
        value = value * 10 + (uint64_t)(*at - '0');
        if (value > UINT32_MAX) {
            return NULL;
        }
    }
    *number = (uint32_t)value;
    return at;
}

bool numbers_read(const char *text, char separator, uint32_t *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        text = read_one(text, &numbers[i]);
        if (text == NULL || *text != (i + 1 < count ? separator : '\0')) {
            return false;
        }
        text++;
    }
    return true;
}

int number_read(const char *option, const char *text, uint32_t least, uint32_t most, uint32_t *number)
{
    if (numbers_read(text, '\0', number, 1) && *number >= least && *number <= most) {
        return DONE;
    }
    return fail_usage("%s %s: not a whole number from %lu to %lu", option, text, (unsigned long)least,
                      (unsigned long)most);
}

int threshold_read(const char *option, const char *text, double *threshold)
{
    char *end;
    /* strtod alone would take blanks, hexadecimals, inf and nan as well. */
    if (text[strspn(text, "0123456789.eE+-")] == '\0') {
        *threshold = strtod(text, &end);
        if (end != text && *end == '\0' && *threshold >= 0 && isfinite(*threshold)) {
            return DONE;
        }
    }
    return fail_usage("%s %s: not a number from 0", option, text);
}
