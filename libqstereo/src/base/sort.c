#include "sort.h"

#include <string.h>

/* Merges the sorted runs [0, middle) and [middle, count) of `from`. */
static void merge(const uint32_t *from, size_t middle, size_t count, uint32_t *to,
                  qs_before *before, const void *context)
{
    size_t a = 0, b = middle;
    for (size_t n = 0; n < count; n++) {
        bool second = a == middle || (b < count && before(context, from[b], from[a]));
        to[n] = from[second ? b++ : a++];
    }
}

void qs_sort(uint32_t *items, uint32_t *scratch, size_t count, qs_before *before,
             const void *context)
{
    for (size_t run = 1; run < count; run *= 2) {
        for (size_t at = 0; count - at > run; at += 2 * run) {
            size_t both = count - at < 2 * run ? count - at : 2 * run;
            if (before(context, items[at + run], items[at + run - 1])) {
                merge(items + at, run, both, scratch, before, context);
                memcpy(items + at, scratch, both * sizeof *items);
            }
            if (both < 2 * run) {
                break;
            }
        }
    }
}
