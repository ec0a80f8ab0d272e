/* The solver `cut`: which minimum cuts solve a problem, if any. */
#ifndef QS_CUT_H
#define QS_CUT_H

#include "../../include/qstereo/solve.h"

/* Whether qs_min_cut solves it in less time than messages take, whatever the costs are: two labels,
 * convex costs, or linear costs on a grid. */
bool qs_cut_is_quick(const qs_model *model);

#endif
