#include "trws_split.h"

#include "../base/minmax.h"
#include "trws_visit.h"

/* Tells of one chain at a site. What it is charged is `costs`, less the message that comes along
 * it. Leaves `costs` as they were. */
static void tell(const qs_trws_state *state, const qs_witness *witness, uint32_t site,
                 uint32_t chain, qs_number *costs, const qs_number *came)
{
    uint32_t labels = state->model->labels;
    for (uint32_t d = 0; d < labels; d++) {
        costs[d] -= came[d];
    }
    witness->share(witness->context, state->model, site, chain, costs, sizeof *costs);
    for (uint32_t d = 0; d < labels; d++) {
        costs[d] += came[d];
    }
}

static void split_grid(const qs_trws_state *state, const qs_witness *witness)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels;
    qs_number *row = state->scratch, *column = row + labels, *rest = column + labels;
    for (uint32_t at = 0; at < qs_trws_visits(state); at++) {
        uint32_t p = qs_trws_site(state, at, true);
        qs_visit v = qs_visit_of(state, p, labels, true);
        qs_visit_charge(state, &v, labels, row, column);
        tell(state, witness, p, 0, row, v.row_in);
        tell(state, witness, p, 1, column, v.column_in);
        (void)qs_message_send(model, v.row_edge, v.row_weight, true, row, v.row_out, rest);
        (void)qs_message_send(model, v.column_edge, v.column_weight, true, column, v.column_out,
                              rest);
    }
}

void qs_trws_split(const qs_trws_state *state, const uint16_t *labelling, const qs_witness *witness)
{
    witness->end(witness->context, state->model->kept); /* what has left before, left without it */
    witness->split(witness->context, state->model, state->scale.shift, labelling);
    if (state->model->width > 0) {
        split_grid(state, witness);
    } else {
        qs_trws_graph_split(state, witness);
    }
}

void qs_witness_split(const qs_trws_state *state, const qs_solve_options *options,
                      const uint16_t *labelling)
{
    if (options && options->witness) {
        qs_trws_split(state, labelling, options->witness);
        options->witness->end(options->witness->context, state->model->kept);
    }
}
