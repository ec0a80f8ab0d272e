/* The right picture's map, which confirms the left one: the mirrored problem, in which the right
 * picture is the left one. Each function that can fail returns an exit status and has printed
 * why. */
#ifndef RIGHT_SIDE_H
#define RIGHT_SIDE_H

#include "made.h"
#include "pair.h"

typedef struct right_side {
    qs_matching stereo; /* the mirrored pictures */
    made_problem made;
    laid_out laid;
    solved found;
} right_side;

/* Makes the problem and lays it out for the solver, in memory of the budget.
 *
 * iterations  as in a search
 * straight    no model is needed after the solver */
int right_side_make(const pair *of, const solver *by, uint64_t iterations, bool straight,
                    budget *limit, right_side *right);

#endif
