/* The sweeps of loopy belief propagation. As in the study's code a new message is mixed with the
 * one before, without which energies settle higher: there it keeps 1/5 of that, here 3/16. The
 * mixture is rounded to the side of the new one, so that on a chain the messages become the exact
 * ones. */
#ifndef QS_BP_H
#define QS_BP_H

#include "messages.h"

/* The messages to a grid's site, in the order they stand in memory, each of `labels` numbers. */
enum { QS_FROM_LEFT, QS_FROM_RIGHT, QS_FROM_ABOVE, QS_FROM_BELOW, QS_FROM_ALL };

/* The state between sweeps. */
typedef struct qs_bp_state {
    const qs_model *model;
    qs_scale scale;
    int32_t *messages; /* of a grid: of each site those to it; else of each edge that to the higher
                          site, then that to the lower */
    int32_t *scratch;
} qs_bp_state;

enum { QS_KEEP = 3, QS_KEEP_OF = 4 }; /* 3 / 2^4 */

size_t qs_bp_messages(const qs_model *model);
size_t qs_bp_scratch(const qs_model *model);

/* Sends as qs_message_send does, but mixed with the message before; scratch: qs_message_scratch
 * numbers after `labels` ones. */
void qs_bp_send(const qs_bp_state *state, int32_t weight, bool upward, int32_t *costs,
                int32_t *message, int32_t *scratch);

/* An iteration of messages. */
void qs_bp_grid_sweep(const qs_bp_state *state);
void qs_bp_graph_sweep(const qs_bp_state *state);
void qs_bp_wide_sweep(const qs_bp_state *state); /* of a grid with Potts costs and at least 8 labels
                                                    by AVX2, to the bit */

/* A labelling as that of decode.h. */
void qs_bp_graph_labels(const qs_bp_state *state, uint16_t *labelling);

#endif
