/* The unary costs of a problem, a few sites at a time, whether they stand in an array or are made
 * when they are needed. From the costs of each site their least is subtracted. */
#ifndef QS_COST_STRIPS_H
#define QS_COST_STRIPS_H

#include <stdbool.h>

#include "../../include/qstereo/problem.h"

/* A strip: a row of a grid whose costs are made, else some sites one after another. */
typedef struct qs_strip {
    const qs_problem *problem;
    uint32_t next; /* the row, or site, that the next strip begins with */
    uint32_t total; /* rows, or sites, of the problem */
    uint32_t sites; /* in this strip */
    unsigned bytes; /* of a cost: 1 or 4 */
    void *costs; /* sites x labels, uint8_t or uint32_t; the user may overwrite them */
    int32_t *least; /* what was subtracted at each site, */
    int64_t least_sum; /* and in all */
} qs_strip;

/* Bytes of workspace, aligned for uint32_t. */
size_t qs_costs_workspace(const qs_problem *problem);

/* The state before the first strip. */
qs_strip qs_strip_first(const qs_problem *problem, void *workspace);

/* Computes the next strip. Returns false after the last. */
bool qs_strip_next(qs_strip *strip);

/* Cost `at` of a strip's sites x labels. */
int64_t qs_strip_cost(const qs_strip *strip, size_t at);

#endif
