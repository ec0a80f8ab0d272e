/* The sweeps of loopy belief propagation.
 *
 * A new message is mixed with the one before it; without that, energies settle higher. The study's
 * code (Szeliski et al. 2008) keeps 1/5 of the old message, this keeps 3/16. The mixture is rounded
 * towards the new message, so that on a chain the messages become the exact ones. */
#ifndef QS_BP_H
#define QS_BP_H

#include "../model/neighbours.h"
#include "messages.h"
#include "progress.h"

/* The messages to a site of a grid, in the order in which they stand in memory, `labels` numbers
 * each. */
enum { QS_FROM_LEFT, QS_FROM_RIGHT, QS_FROM_ABOVE, QS_FROM_BELOW, QS_FROM_ALL };

/* The state between sweeps. */
typedef struct qs_bp_state {
    const qs_model *model;
    qs_scale scale;
    /* Of a grid the messages to each site. Of a graph, for each edge, that to the higher-numbered
     * site, then that to the lower. */
    qs_number *messages;
    qs_number *scratch;
    qs_look *look; /* NULL = nothing stops a sweep */
} qs_bp_state;

/* The old message that is kept: QS_KEEP / 2^QS_KEEP_OF. */
enum { QS_KEEP = 3, QS_KEEP_OF = 4 };

/* Sends as qs_message_send does, and mixes the message with the one before.
 *
 * scratch  `labels` numbers, and then qs_message_scratch more */
void qs_bp_send(const qs_bp_state *state, uint32_t edge, qs_number weight, bool upward,
                qs_number *costs, qs_number *message, qs_number *scratch);

/* In a loop over the sites: false if the sweep is to stop. */
static inline bool qs_bp_going(const qs_bp_state *state, uint32_t at)
{
    const qs_model *model = state->model;
    bool table = model->pairwise.smoothness >= QS_TABLE;
    uint64_t labels = model->labels, each = table ? labels * labels : labels;
    return model->width > 0 ? qs_look_at(state->look, at, each)
                            : qs_look_up(state->look, each * (1 + qs_edges_at(model, at)));
}

/* The sweeps of one iteration. The wide one is for grids with Potts costs and at least 8 labels; it
 * computes the same by AVX2. */
void qs_bp_grid_sweep(const qs_bp_state *state);
void qs_bp_graph_sweep(const qs_bp_state *state);
void qs_bp_wide_sweep(const qs_bp_state *state);

/* A labelling of a graph from the messages, as label_from_messages.h says. */
void qs_bp_graph_labels(const qs_bp_state *state, uint16_t *labelling);

#endif
