/* qs_reduce, as qs_best makes use of it. */
#ifndef QS_REDUCER_H
#define QS_REDUCER_H

#include "../../include/qstereo/reduce.h"

/* What a reduction is for. All zero = to take out all that it can. */
typedef struct qs_reduce_aim {
    bool answer; /* the labelling and its proof: what may still leave after that stays */
} qs_reduce_aim;

/* The arguments are those of qs_reduce.
 *
 * converged  out: it came to its end by itself */
qs_status qs_reduce_as(const qs_model *model, const qs_reduce_options *options,
                       const qs_reduce_aim *aim, void *workspace, size_t workspace_size,
                       uint8_t *kept, uint16_t *labelling, qs_reduction *reduction,
                       bool *converged);

#endif
