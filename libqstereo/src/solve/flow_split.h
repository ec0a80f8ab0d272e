/* What a minimum cut tells a witness: its flow, as a split of the costs among chains
 * (docs/MATHS.md, section 19). The part of an edge's costs that the flow moves to one of its sites
 * is taken from the share of the edge's chain there; so on the chain nothing is left of it. */
#ifndef QS_FLOW_SPLIT_H
#define QS_FLOW_SPLIT_H

#include "../../include/qstereo/solve.h"
#include "../base/arena.h"
#include "../model/neighbours.h"

typedef struct qs_flow_split {
    const qs_model *model;
    int64_t *sum; /* one number for each label */
} qs_flow_split;

static inline void qs_flow_split_take(qs_flow_split *split, const qs_model *model, qs_arena *arena)
{
    split->model = model;
    split->sum = qs_arena_take(arena, model->labels, sizeof *split->sum);
}

/* Adds to the sum of each label what the edge takes off it at a site that sees it as edge `at`:
 * minus the part of its costs that the flow has moved to that site. Any numbers prove a bound. */
typedef void qs_edge_takes(const void *context, uint32_t site, uint32_t at,
                           const qs_edge_seen *edge, int64_t *sum);

/* Tells the witness, if the options have one.
 *
 * shift      the flow is of costs times 2^shift
 * labelling  the best known, of labels left */
void qs_flow_split_tell(const qs_flow_split *split, const qs_solve_options *options, unsigned shift,
                        const uint16_t *labelling, qs_edge_takes *takes, const void *context);

/* Tells of a split in which nothing has moved: it proves what little needs no work. For who was
 * stopped before there was another.
 *
 * witness  NULL = nobody */
void qs_flow_split_none(const qs_model *model, const qs_witness *witness,
                        const uint16_t *labelling);

#endif
