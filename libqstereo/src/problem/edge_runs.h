/* The edges of a problem, as a few runs of alike ones in the order of a .qcf: of a grid first those
 * to right neighbours, then those to lower ones; else the list. */
#ifndef QS_EDGE_RUNS_H
#define QS_EDGE_RUNS_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"

/* Returns true if a cell of a grid is not masked. There is none below the last row. */
static inline bool qs_is_site(const qs_grid *grid, uint32_t x, uint32_t y)
{
    return y < grid->height && (!grid->mask || grid->mask[(size_t)y * grid->width + x] != 0);
}

/* The weight of the edge from a cell to its right or its lower neighbour; 0 = there is none. */
int32_t qs_cell_weight(const qs_problem *problem, uint32_t x, uint32_t y, bool down);

/* A run: the pairs of sites (first + r * stride + c, second + r * stride + c) with r < repeat and c
 * < count. Where `list` is given it is the `count` edges of the list. */
typedef struct qs_edge_run {
    uint32_t first, second, count, repeat, stride;
    const qs_edge *list;
    const int32_t *weights; /* weights[r * pitch + c] is that of pair (r, c). NULL and no list = the
                               problem has one weight for all */
    size_t pitch;
} qs_edge_run;

typedef void qs_edge_visit(void *context, const qs_edge_run *run);

/* Visits all runs. A grid with one weight for all has none if that is 0. */
void qs_edges_visit(const qs_problem *problem, qs_edge_visit *visit, void *context);

/* The weight of pair (r, c) of a run. */
int32_t qs_edge_weight(const qs_problem *problem, const qs_edge_run *run, uint32_t r, uint32_t c);

/* Called for `count` sites one after another that are alike: `first` is the sum of the weights of
 * the edges of which such a site is the first one, `second` of those of which it is the second. */
typedef void qs_reach_visit(void *context, uint32_t count, int64_t first, int64_t second);

/* Visits all sites in order.
 *
 * sums  memory for 2 x sites, of a problem with a list of edges; of grids it is not used */
void qs_reach_visit_all(const qs_problem *problem, int64_t *sums, qs_reach_visit *visit,
                        void *context);

#endif
