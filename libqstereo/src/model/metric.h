/* What kind of distance the pairwise cost of a model is. Moves need to know. Tables of edges are
 * not looked at: they count as none. */
#ifndef QS_METRIC_H
#define QS_METRIC_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"

/* Returns true if V(a, a) = 0 and V(a, b) = V(b, a) for all labels. */
bool qs_is_semi_metric(const qs_model *model);

/* Returns true if V is a semi-metric and V(a, c) <= V(a, b) + V(b, c) for all labels. */
bool qs_is_metric(const qs_model *model);

#endif
