/* A problem's unary costs, strip after strip, each site's less their least: from the caller's array
 * or from the maker. */
#ifndef QS_COST_STRIPS_H
#define QS_COST_STRIPS_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"

/* A strip of consecutive sites: a row of a grid whose costs are made, else a handful of sites. */
typedef struct qs_strip {
    const qs_problem *problem;
    uint32_t next; /* row, or site, that the next strip begins with */
    uint32_t total; /* rows, or sites */
    uint32_t sites; /* in this strip */
    unsigned bytes; /* of a cost: 1 or 4 */
    int64_t least_sum; /* what has been subtracted from the strip's sites, one by one, in all */
    void *costs; /* sites x labels, uint8_t or uint32_t; the user may overwrite them */
    int32_t *least;
} qs_strip;

/* Bytes of workspace, aligned for uint32_t. */
size_t qs_costs_workspace(const qs_problem *problem);

/* Before the first strip. */
qs_strip qs_strip_first(const qs_problem *problem, void *workspace);

/* Computes the next strip; false after the last. */
bool qs_strip_next(qs_strip *strip);

/* Cost `at` of the strip's sites x labels. */
int64_t qs_strip_cost(const qs_strip *strip, size_t at);

#endif
