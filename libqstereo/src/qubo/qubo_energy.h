/* Parts of H of a sample, group by group. */
#ifndef QS_QUBO_ENERGY_H
#define QS_QUBO_ENERGY_H

#include "../../include/qstereo/qubo.h"

/* The entry of a group's block with a neighbour. `own` and `other` are variables, counted from the
 * first one of each group. */
static inline int32_t qs_near_entry(const qs_index *index, const qs_neighbour *near, uint32_t own,
                                    uint32_t other)
{
    bool turned = (near->block & QS_TRANSPOSED) != 0;
    return qs_index_block(index, near->block & ~QS_TRANSPOSED, turned ? other : own,
                          turned ? own : other);
}

/* What `variable` costs if it is 1 and the other groups are as they are. */
int64_t qs_field(const qs_index *index, const uint8_t *bits, uint32_t group, uint32_t variable);

#endif
