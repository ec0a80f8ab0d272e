/* The edges of a problem whose edges have tables of their own (QS_TABLES), a strip at a time: of a
 * grid first the edges to the right, row by row, then those down; else the whole list. So of tables
 * that are made no more than a row is in memory. */
#ifndef QS_EDGE_TABLES_H
#define QS_EDGE_TABLES_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"
#include "../base/arena.h"

typedef struct qs_table_strip {
    const qs_problem *problem;
    uint32_t count; /* places of edges in this strip */
    bool down;
    uint32_t row; /* of a grid: the next one; of a list: 1 once it has been visited */
    /* The workspace, of grids only. */
    int32_t *tables; /* a row of edges to the right, and a row of edges down */
    uint32_t *here, *below; /* the number of the first site at or after each cell of a row */
} qs_table_strip;

/* An edge. Of weight 0: there is none, and the other fields mean nothing. */
typedef struct qs_table_edge {
    uint32_t first, second;
    int32_t weight;
    const int32_t *table;
} qs_table_edge;

/* The state before the first strip, with its workspace from an arena. */
qs_table_strip qs_table_strip_first(const qs_problem *problem, qs_arena *arena);

/* Makes the next strip. Returns false after the last. */
bool qs_table_strip_next(qs_table_strip *strip);

/* The edge at place `at`, 0 .. count - 1, of a strip. */
qs_table_edge qs_table_edge_at(const qs_table_strip *strip, uint32_t at);

/* Called for each site in order: `most` is what its edges can cost it at most,
 * max_d sum_q weight_pq max_e V_pq(d, e), saturated above QS_ENERGY_MAX. */
typedef void qs_table_reach_visit(void *context, uint64_t most);

/* Numbers of workspace for qs_table_reach_all: of a grid for two rows of labels, else for all
 * labels. */
uint64_t qs_table_reach_numbers(const qs_problem *problem);

/* Visits all sites. */
void qs_table_reach_all(const qs_table_strip *strip, uint64_t *reach, qs_table_reach_visit *visit,
                        void *context);

#endif
