/* qs_reduce in numbers of 64 bits, to which it hands over where costs are too large (number.h). */
#ifndef QS_HAND_OVER_H
#define QS_HAND_OVER_H

#include "../../include/qstereo/reduce.h"

size_t qs_reduce_workspace_64(const qs_model *model);
qs_status qs_reduce_64(const qs_model *model, const qs_reduce_options *options, void *workspace,
                       size_t workspace_size, uint8_t *kept, uint16_t *labelling,
                       qs_reduction *reduction);

#endif
