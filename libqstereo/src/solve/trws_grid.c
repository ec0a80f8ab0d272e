#include "trws_passes.h"

#include "../base/minmax.h"
#include "label_from_messages.h"
#include "trws_visit.h"

uint64_t qs_trws_messages(const qs_model *model)
{
    return (model->width > 0 ? 2 * (uint64_t)model->sites : model->edges) * model->labels;
}

uint64_t qs_trws_padding(const qs_model *model)
{
    return model->width > 0 ? 2 * (uint64_t)model->labels * model->width : 0;
}

QS_KERNEL qs_number send_potts(const qs_number *costs, qs_number *message, uint32_t labels,
                               qs_number weight)
{
    qs_number least = costs[0];
    for (uint32_t d = 1; d < labels; d++) {
        least = qs_min_number(least, costs[d]);
    }
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = qs_min_number(costs[d] - least, weight);
    }
    return least;
}

QS_KERNEL int64_t potts_pass(const qs_trws_state *state, bool forward)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels;
    qs_number *row = state->scratch, *column = row + labels;
    int64_t bound = 0;
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        qs_visit v = qs_visit_of(state, qs_trws_site(state, at, forward), labels, forward);
        qs_visit_charge(state, &v, labels, row, column);
        bound += send_potts(row, v.row_out, labels, v.row_weight);
        bound += send_potts(column, v.column_out, labels, v.column_weight);
    }
    return bound;
}

static int64_t other_pass(const qs_trws_state *state, bool forward)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels;
    qs_number *row = state->scratch, *column = row + labels, *rest = column + labels;
    int64_t bound = 0;
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        qs_visit v = qs_visit_of(state, qs_trws_site(state, at, forward), labels, forward);
        qs_visit_charge(state, &v, labels, row, column);
        bound += qs_message_send(model, v.row_edge, v.row_weight, forward, row, v.row_out, rest);
        bound += qs_message_send(model, v.column_edge, v.column_weight, forward, column,
                                 v.column_out, rest);
    }
    return bound;
}

int64_t qs_trws_grid_pass(const qs_trws_state *state, bool forward)
{
#if QS_HAVE_AVX2 && QS_BITS == 32
    qs_smoothness smoothness = state->model->pairwise.smoothness;
    if (state->wide && smoothness >= QS_TABLE) {
        return qs_trws_wide_tables_pass(state, forward);
    }
    if (state->wide && smoothness <= QS_TRUNCATED_LINEAR && state->model->labels >= QS_LANES) {
        return qs_trws_wide_pass(state, forward);
    }
#endif
    if (state->model->pairwise.smoothness != QS_POTTS) {
        return other_pass(state, forward);
    }
    return forward ? potts_pass(state, true) : potts_pass(state, false);
}

/* Three rows of costs, rounded up to whole runs of lanes, and what a message needs. */
uint64_t qs_trws_scratch(const qs_model *model)
{
    enum { RUN = 8 };
    return 3 * ((uint64_t)model->labels + RUN) + qs_message_scratch(model);
}

void qs_trws_grid_labels(const qs_trws_state *state, bool forward, uint16_t *labelling)
{
    size_t labels = state->model->labels, site = 2 * labels;
    const qs_number *row = forward ? state->messages : state->messages - site;
    const qs_number *column =
        (forward ? state->messages : state->messages - site * state->model->width) + labels;
    qs_message_reader reader = {state->model, state->scale, state->wide,    forward,    row,
                                column,       site,         state->scratch, state->look};
    qs_label_grid(&reader, labelling);
}
