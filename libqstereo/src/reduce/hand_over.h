/* qs_reduce and qs_best in numbers of 64 bits, to which they hand over where costs are too large
 * (number.h). */
#ifndef QS_HAND_OVER_H
#define QS_HAND_OVER_H

#include "reducer.h"

qs_solver qs_best_64;
size_t qs_best_workspace_64(const qs_model *model);
size_t qs_reduce_workspace_64(const qs_model *model);
qs_status qs_reduce_as_64(const qs_model *model, const qs_reduce_options *options,
                          const qs_reduce_aim *aim, void *workspace, size_t workspace_size,
                          uint8_t *kept, uint16_t *labelling, qs_reduction *reduction,
                          bool *converged);
qs_status qs_reduce_64(const qs_model *model, const qs_reduce_options *options, void *workspace,
                       size_t workspace_size, uint8_t *kept, uint16_t *labelling,
                       qs_reduction *reduction);

#endif
