/* Elimination of the nodes one after the other (Bertele and Brioschi 1972; bucket elimination,
 * Dechter 1999): exact, with memory and time that grow with the widest table of the order. */
#ifndef QS_BUCKET_H
#define QS_BUCKET_H

#include "../base/arena.h"
#include "tables.h"

enum { QS_BUCKET_WIDEST = 24, QS_BUCKET_FUNCTIONS = 48 };

/* Costs of some nodes, as a table. The first node of the scope is the one that leaves first, and
 * its labels are next to each other. */
typedef struct qs_bucket_function {
    size_t table, scope; /* where they begin in `cells` and in `scopes` */
    uint32_t size; /* of the scope */
    uint32_t next; /* of the same node; UINT32_MAX = none */
} qs_bucket_function;

typedef struct qs_bucket {
    const qs_tables *t;
    size_t cell_limit; /* numbers in `cells` */
    int64_t *cells;
    uint32_t *open; /* the nodes with several labels, `count` */
    uint32_t count;
    uint32_t *place; /* of each node: where it is in `open` */
    uint32_t *labels; /* of each node its labels left, where its costs begin */
    uint32_t *order, *turn; /* places in the order of leaving, and the turn of each place */
    uint64_t *near; /* of each place the places joined to it, as bits */
    uint64_t *gone; /* places that have left, as bits */
    uint32_t *fill; /* of each place: pairs that its leaving would join */
    uint32_t *scopes;
    size_t scopes_used, scopes_limit, cells_used;
    qs_bucket_function *functions;
    uint32_t function_count;
    uint32_t *first; /* of each place: the first function of its bucket */
    uint32_t *chosen; /* of each place: the label's number among those left */
} qs_bucket;

/* Takes memory, with room for that many numbers. t is set. */
void qs_bucket_take(qs_bucket *b, size_t cells, qs_arena *arena);

/* Solves what is left: qs_tables_tighten and qs_tables_collect have been called. Returns false if
 * that takes more numbers than there is room for, or if the watch stops it. An allowance that comes
 * to its end does not.
 *
 * value  out: the least S F
 * best   out: the labels of one labelling that has it
 * work   less by the numbers looked at */
bool qs_bucket_solve(qs_bucket *b, const qs_table_costs *c, int64_t *value, uint32_t *best,
                     qs_allowance *work);

#endif
