/* The parts of which labelling.c makes a problem: its costs, its mask, and the weights, tables and
 * edges that join its sites. Each function that can fail returns DONE, BAD_USAGE, BAD_INPUT or
 * NO_RESOURCE, and has printed why. What it opens is the budget's, or stays in the file that is
 * mapped. */
#ifndef LABELLING_PARTS_H
#define LABELLING_PARTS_H

#include "makers/labelling.h"

/* ---- Shapes of arrays. ---- */

/* Says that an array has its shape, "but " what is needed. */
int labelling_fail_shape(const npy_array *array, const char *needed);

/* Checks the first `dimensions` lengths, and that there are no more.
 *
 * what  "weights to the right" */
int labelling_check_shape(const npy_array *array, const char *what, const uint64_t *shape,
                          unsigned dimensions);

/* Opens the two arrays of "RIGHT.npy,DOWN.npy". */
int labelling_open_two(const char *option, const char *text, budget *limit, npy_array *right,
                       npy_array *down);

/* Opens the one array of an option of graphs. */
int labelling_open_one(const char *option, const char *text, budget *limit, npy_array *opened);

/* Checks that an array holds whole numbers. */
int labelling_check_whole(const npy_array *array, const char *needed);

/* What to do about costs that are too large. */
const char *labelling_mend(const labelling_request *asked);

/* ---- Costs and sites. ---- */

/* Takes sites and labels from the shape of the costs, which are open. */
int labelling_check_costs(const labelling_request *asked, qs_problem *problem);

/* Opens the costs themselves, where the sites are known. */
int labelling_open_costs(labelling_request *asked, budget *limit, qs_problem *problem);

/* Opens --mask, if it is given. */
int labelling_open_mask(const labelling_request *asked, budget *limit, qs_problem *problem);

/* Whether a cell of a grid, or a node, is a site: not masked. */
static inline bool labelling_is_site(const qs_problem *problem, uint64_t cell)
{
    return problem->grid.mask == NULL || problem->grid.mask[cell] != 0;
}

/* ---- Floats. ---- */

/* Warns if an array of floats loses something at the scale that was not chosen.
 *
 * by            how it becomes units
 * units_in_one  by.times units are so many */
void labelling_warn_rounding(const labelling_request *asked, const qs_problem *problem,
                             const npy_array *array, npy_scaling by, uint32_t units_in_one);

/* ---- What neighbours cost. Each does nothing where its option is not given. ---- */

int labelling_open_pairwise(labelling_request *asked, budget *limit, qs_problem *problem);
int labelling_open_grid_tables(labelling_request *asked, budget *limit, qs_problem *problem);
int labelling_open_edge_tables(labelling_request *asked, uint64_t count, budget *limit,
                               qs_problem *problem);
int labelling_open_grid_weights(const labelling_request *asked, budget *limit, qs_problem *problem);

/* weights  out: of the edges; NULL if they are not given */
int labelling_open_edge_weights(const labelling_request *asked, const qs_problem *problem,
                                uint64_t count, budget *limit, const int32_t **weights);

/* Opens --edges, with their weights and tables. */
int labelling_open_edges(labelling_request *asked, budget *limit, qs_problem *problem);

#endif
