#include "../base/minmax.h"
#include "bp_visit.h"

static void send(const qs_bp_state *state, uint32_t site, int from)
{
    uint32_t labels = state->model->labels;
    qs_number *costs = state->scratch;
    qs_letter letter = qs_letter_of(state, site, labels, from);
    for (uint32_t d = 0; d < labels; d++) {
        costs[d] = qs_scaled_cost(state->model, state->scale, letter.first + d) + letter.behind[d] +
                   letter.beside[0][d] + letter.beside[1][d];
    }
    qs_bp_send(state, letter.edge, letter.weight, from == QS_FROM_LEFT || from == QS_FROM_ABOVE,
               costs, letter.message, costs + labels);
}

void qs_bp_grid_sweep(const qs_bp_state *state)
{
    uint32_t width = state->model->width, sites = state->model->sites;
    for (uint32_t p = 0; p < sites && qs_bp_going(state, p); p++) {
        if ((p + 1) % width != 0) {
            send(state, p, QS_FROM_LEFT);
        }
    }
    for (uint32_t p = sites; p-- > 0 && qs_bp_going(state, p);) {
        if (p % width != 0) {
            send(state, p, QS_FROM_RIGHT);
        }
    }
    for (uint32_t p = 0; p + width < sites && qs_bp_going(state, p); p++) {
        send(state, p, QS_FROM_ABOVE);
    }
    for (uint32_t p = sites; p-- > width && qs_bp_going(state, p);) {
        send(state, p, QS_FROM_BELOW);
    }
}
