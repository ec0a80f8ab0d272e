/* Both sides of a pair: what is made and found of the left picture, and the same of the right one,
 * whose map confirms the left one. The problem of the right side is mirrored: in it the right
 * picture is the left one. Each function that can fail returns an exit status and has printed
 * why. */
#ifndef RIGHT_SIDE_H
#define RIGHT_SIDE_H

#include "halves.h"
#include "made.h"
#include "pair.h"

typedef struct side {
    qs_matching stereo; /* of the right side mirrored */
    made_problem made;
    laid_out laid;
    solved found; /* no labelling = it is not solved yet */
    bool halved; /* half pixels are wanted of what is found: */
    halves finer;
} side;

/* Makes the problem and lays it out for the solver, in memory of the budget.
 *
 * iterations  as in a search
 * straight    no model is needed after the solver
 * right       halved says whether half pixels are begun, too */
int right_side_make(const pair *of, const solver *by, uint64_t iterations, bool straight,
                    budget *limit, side *right);

/* The half pixels that are wanted of a side, else NULL. */
halves *side_halves(side *of);

#endif
