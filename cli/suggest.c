#include "suggest.h"

#include <string.h>

enum { LONGEST = 31 };

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Edit distance (Levenshtein) of two short names; LONGEST + 1 where one is too long to be a slip.
 */
static size_t distance(const char *a, const char *b)
{
    size_t m = strlen(a), n = strlen(b);
    size_t row[LONGEST + 1];
    if (m > LONGEST || n > LONGEST) {
        return LONGEST + 1;
    }
    for (size_t j = 0; j <= n; j++) {
        row[j] = j;
    }
    for (size_t i = 1; i <= m; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= n; j++) {
            size_t changed = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = least(changed, least(row[j], row[j - 1]) + 1);
        }
    }
    return row[n];
}

suggestion suggest_for(const char *typed)
{
    /* With more than every third letter wrong it is another name, not a slip. */
    size_t slips = (strlen(typed) + 1) / 3;
    return (suggestion){typed, NULL, (slips < 1 ? 1 : slips) + 1};
}

void suggest_offer(suggestion *suggested, const char *name)
{
    size_t found = distance(suggested->typed, name);
    if (found < suggested->distance) {
        suggested->distance = found;
        suggested->nearest = name;
    }
}
