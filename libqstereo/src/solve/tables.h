/* A small problem with a table for each edge, and a lower bound that only rises.
 *
 *     S F(x) = constant + sum_p cost_p(x_p) + sum_{pq} table_pq(x_p, x_q)
 *
 * All numbers are at least 0, so `constant` is a lower bound. Every step moves costs from one place
 * to another and leaves the right side as it is for each labelling (equivalent problems;
 * Schlesinger 1976, Cooper and Schiex 2004). The order of the steps is that of TRW-S (Kolmogorov
 * 2006) in the form of Kolmogorov (2015): all that the edges of a node cost whatever the neighbour
 * does goes to the node, and the node's costs go in equal shares to the edges that come later. */
#ifndef QS_TABLES_H
#define QS_TABLES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../base/hidden.h"
#include "progress.h"

enum { QS_TABLES_BITS = 50 }; /* S F of any labelling stays below 2^50 */

#define QS_TABLES_OUT INT64_MAX /* the cost of a label that has left its node */

typedef struct qs_table_edge {
    uint32_t first, second; /* nodes, first < second */
    uint32_t table; /* where its labels(first) x labels(second) numbers begin */
} qs_table_edge;

/* What stays the same. */
typedef struct qs_tables {
    uint32_t nodes, edges;
    uint32_t cells; /* numbers in all: of the labels, then of the tables */
    uint32_t *start; /* nodes + 1: where the costs of each node's labels begin */
    qs_table_edge *edge;
    uint32_t *link_start; /* nodes + 1 */
    uint32_t *link; /* 2 x edges: the edges of each node, by the other node */
} qs_tables;

/* What the steps change. */
typedef struct qs_table_costs {
    int64_t constant;
    int64_t *cells;
    uint32_t *left; /* of each node: how many labels are left; 0 somewhere = no labelling is */
} qs_table_costs;

/* Fills in link_start and link. The rest is there. */
void qs_tables_link(qs_tables *t);

static inline uint32_t qs_tables_labels(const qs_tables *t, uint32_t node)
{
    return t->start[node + 1] - t->start[node];
}

/* Copies costs. */
void qs_tables_copy(const qs_tables *t, const qs_table_costs *from, qs_table_costs *to);

/* Takes all labels of a node out but one. */
QS_HIDDEN void qs_tables_fix(const qs_tables *t, qs_table_costs *c, uint32_t node, uint32_t label);

/* Takes a label out. */
QS_HIDDEN void qs_tables_leave(const qs_tables *t, qs_table_costs *c, uint32_t node,
                               uint32_t label);

/* Passes over all nodes, forward and backward in turn, until the bound no longer rises by a
 * worthwhile part of what is missing to `most`, or after `passes`. Labels without which no
 * labelling has S F <= most leave.
 *
 * work  less by the numbers looked at; the passes end when it is used up
 * Returns false if no labelling has S F <= most. */
bool qs_tables_tighten(const qs_tables *t, qs_table_costs *c, int64_t most, uint32_t passes,
                       qs_allowance *work);

/* Moves to each node of several labels what its edges cost whatever the neighbours do. After
 * qs_tables_tighten nodes of one label, and their edges, then cost nothing. */
void qs_tables_collect(const qs_tables *t, const qs_table_costs *c);

#endif
