/* One minimum cut that is the optimum: Ishikawa's graph (2003), in the form of Schlesinger and
 * Flach (2006).
 *
 * Level i of site p is a binary variable: 1 where p's label is above i, i = 0 .. labels - 2. Level
 * i + 1 at 1 and level i at 0 costs more than all else, so the levels of a site are a label. The
 * mixed second differences of V are the coefficients of products of levels; where V is submodular
 * they are at most 0, and the binary problem is a minimum cut. The unary costs may be any. With two
 * labels there is one level, and the cut is that of Boykov and Jolly (2001). */
#ifndef QS_CUT_LEVELS_H
#define QS_CUT_LEVELS_H

#include "../../include/qstereo/solve.h"

/* Bytes of workspace; SIZE_MAX where the graph would be larger than any machine's memory or has
 * 2^32 nodes or arcs. V must be submodular. */
size_t qs_levels_workspace(const qs_model *model);

/* Whether the costs are small enough for numbers of this width. V must be submodular. */
bool qs_levels_fit(const qs_model *model);

/* Whether messages go before the flow (V is submodular): of linear costs on a grid, with more than
 * a few labels. */
bool qs_levels_send(const qs_model *model);

/* As a qs_solver; V must be submodular and the labelling in range. Stopped, it gives the labelling
 * of the messages, or without these the one that it was given, and the bound that the flow proves
 * until then. */
qs_status qs_levels(const qs_model *model, const qs_solve_options *options, void *workspace,
                    uint16_t *labelling, qs_solution *solution);

#endif
