/* The solvers in numbers of 64 bits (number.h). Those of solve.h hand over to them where costs are
 * too large for 32 bits; the arguments are the same. */
#ifndef QS_SOLVE_64_H
#define QS_SOLVE_64_H

#include "../../include/qstereo/solve.h"
#include "number.h"

qs_solver qs_expansion_64, qs_swap_64, qs_bp_64, qs_trws_64, qs_min_cut_64;

size_t qs_expansion_workspace_64(const qs_model *model);
size_t qs_swap_workspace_64(const qs_model *model);
size_t qs_bp_workspace_64(const qs_model *model);
size_t qs_trws_workspace_64(const qs_model *model);
size_t qs_min_cut_workspace_64(const qs_model *model);

#endif
