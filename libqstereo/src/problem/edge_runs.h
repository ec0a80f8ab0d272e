/* The edges of a problem as few runs, in the order of the file: right neighbours, then lower ones;
 * or the list. */
#ifndef QS_EDGE_RUNS_H
#define QS_EDGE_RUNS_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"

/* The pairs of sites (first + r * stride + c, second + r * stride + c), r < repeat, c < count; or,
 * where `list` is given, its `count` edges. */
typedef struct qs_edge_run {
    uint32_t first, second, count, repeat, stride;
    const qs_edge *list;
    const int32_t *weights; /* of pair (r, c): weights[r * pitch + c]; NULL (and no list) = the
                               problem's one weight */
    size_t pitch;
} qs_edge_run;

typedef void qs_edge_visit(void *context, const qs_edge_run *run);

/* Visits every run. Edges of a grid with one weight of 0 are left out. */
void qs_edges_visit(const qs_problem *problem, qs_edge_visit *visit, void *context);

/* Weight of pair (r, c) of a run. */
int32_t qs_edge_weight(const qs_problem *problem, const qs_edge_run *run, uint32_t r, uint32_t c);

/* For each site, in order: the sum of the weights of its edges in which it comes first, and second.
 * Visited as runs of `count` neighbouring sites alike.
 *
 * sums  2 x sites, memory for problems given as a list of edges (for grids it is not used) */
typedef void qs_reach_visit(void *context, uint32_t count, int64_t first, int64_t second);
void qs_reach_visit_all(const qs_problem *problem, int64_t *sums, qs_reach_visit *visit,
                        void *context);

#endif
