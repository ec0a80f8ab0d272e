/* The costs that minimum cuts solve exactly, and how to recognise them. */
#ifndef QS_CONVEXITY_H
#define QS_CONVEXITY_H

#include "../../include/qstereo/model.h"

/* Whether V is submodular: for all labels V(a, b) + V(a + 1, b + 1) <= V(a + 1, b) +
 * V(a, b + 1). Where each edge has a table: whether there are two labels, and that is so of the
 * table of each edge with a weight. */
bool qs_pairwise_is_submodular(const qs_model *model);

/* Whether V(a, b) = g(a - b) with a convex g. Then V is submodular. */
bool qs_pairwise_is_convex(const qs_model *model);

/* Whether the labels left to each site have no gaps, and the unary costs are convex on them. */
bool qs_unary_is_convex(const qs_model *model);

#endif
