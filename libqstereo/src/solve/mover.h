/* What expansion and swap share: the model, the present labelling, and the cut that finds a
 * move. */
#ifndef QS_MOVER_H
#define QS_MOVER_H

#include "../base/arena.h"
#include "min_cut.h"

typedef struct qs_mover {
    const qs_model *model;
    uint16_t *x; /* the present labelling */
    qs_cut cut;
    qs_cut_node *padded; /* cut.node, with the nodes around it */
    uint32_t *sister; /* of each link the other link of its edge; graphs only */
    uint64_t now; /* the number of the present move. It starts at two cycles, so that `now` less a
                     cycle is never below 0 */
    int64_t energy;
} qs_mover;

static inline bool qs_is_grid(const qs_model *model)
{
    return model->width > 0;
}

/* Takes the mover's memory. model is set. */
void qs_mover_take(qs_mover *mover, qs_arena *arena);

/* Fills in the cut and computes the energy. The memory has been taken, x is set. */
void qs_mover_start(qs_mover *mover);

/* How many times all pairwise costs of a site fit, on top of its unary costs, into the range that
 * heights are computed in; the least over all sites. INT64_MAX: no edge costs anything. */
int64_t qs_times_in_range(const qs_model *model);

enum { QS_TIMES_NEEDED = 4 }; /* fewer: the model's costs are too large for moves */

#endif
