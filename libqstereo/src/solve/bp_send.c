#include "bp.h"

void qs_bp_send(const qs_bp_state *state, uint32_t edge, int32_t weight, bool upward,
                int32_t *costs, int32_t *message, int32_t *scratch)
{
    uint32_t labels = state->model->labels;
    qs_message_send(state->model, edge, weight, upward, costs, scratch, scratch + labels);
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = scratch[d] +
                     (int32_t)((int64_t)(message[d] - scratch[d]) * QS_KEEP / (1 << QS_KEEP_OF));
    }
}
