/* The order in which an exact solution takes sites out: at each time one that newly joins
 * the fewest pairs, weighted by their labels (weighted minimum fill; Kjaerulff 1990). */
#ifndef QS_EXACT_ORDER_H
#define QS_EXACT_ORDER_H

#include "exact.h"

enum { QS_EXACT_JOINS = 64 }; /* of a site that others have been taken out around */

typedef struct qs_exact_order {
    uint32_t *given; /* the sites of a part, as they came */
    uint32_t
        *joined; /* of each: the numbers of those that it is joined to, QS_EXACT_JOINS at most */
    uint32_t *joins; /* how many */
    uint64_t *harm; /* what it would do if it were the next; 0 = it is in the order */
} qs_exact_order;

/* Hands out the memory, or counts it. */
void qs_exact_order_take(qs_exact_order *order, const qs_stated *stated, qs_arena *arena);

/* Puts the sites of a part, `sites` and `count`, into an order. Returns false if they are no part,
 * or if a table is over too many sites in this order. */
bool qs_exact_order_find(qs_exact_order *order, qs_exact *exact);

#endif
