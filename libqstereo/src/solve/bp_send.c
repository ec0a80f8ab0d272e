#include "bp.h"

void qs_bp_send(const qs_bp_state *state, uint32_t edge, qs_number weight, bool upward,
                qs_number *costs, qs_number *message, qs_number *scratch)
{
    uint32_t labels = state->model->labels;
    qs_message_send(state->model, edge, weight, upward, costs, scratch, scratch + labels);
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = scratch[d] +
                     (qs_number)((int64_t)(message[d] - scratch[d]) * QS_KEEP / (1 << QS_KEEP_OF));
    }
}
