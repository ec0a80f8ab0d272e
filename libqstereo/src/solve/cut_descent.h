/* Steepest descent by minimum cuts, for convex costs (Murota 2003; Kolmogorov and Shioura 2009).
 *
 * Where V(a, b) = g(a - b) with a convex g and each site's unary costs are convex, F is
 * L-natural-convex: a labelling w is optimal if neither w + 1 nor w - 1 on any set of sites costs
 * less (docs/MATHS.md). The best of all sets is a minimum cut. Larger steps come first: they prove
 * nothing, but save cuts. */
#ifndef QS_CUT_DESCENT_H
#define QS_CUT_DESCENT_H

#include "../../include/qstereo/solve.h"

size_t qs_descent_workspace(const qs_model *model);

/* As a qs_solver; the costs must be convex and fit (qs_fusion_fits), and the labelling in range. */
qs_status qs_descent(const qs_model *model, const qs_solve_options *options, void *workspace,
                     uint16_t *labelling, qs_solution *solution);

#endif
