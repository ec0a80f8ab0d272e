/* A stable sort of numbers, each of which stands for an item. */
#ifndef QS_SORT_H
#define QS_SORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Returns true if item a has to stand before item b; of equals neither has to. */
typedef bool qs_before(const void *context, uint32_t a, uint32_t b);

/* Sorts by merging; equals keep their order.
 *
 * scratch  room for `count` */
void qs_sort(uint32_t *items, uint32_t *scratch, size_t count, qs_before *before,
             const void *context);

#endif
