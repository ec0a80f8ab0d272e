/* What a problem says of its sites and labels, without its costs. */
#ifndef QS_LABELS_OF_PROBLEM_H
#define QS_LABELS_OF_PROBLEM_H

#include "../../include/qstereo/model.h"

/* The pairwise cost, with 0 in the fields that its kind does not use. */
qs_pairwise qs_pairwise_of(const qs_problem *problem);

/* As a file in the encoding one-hot would say it.
 *
 * mask  a bit for each cell, as in qs_labels; NULL = none is masked */
qs_labels qs_labels_with_mask(const qs_problem *problem, const uint8_t *mask);

#endif
