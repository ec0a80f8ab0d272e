/* The marginals of labels on grids: of the row and of the column through each site. In plain C, on
 * the same costs as trws_grid.c; it leaves the same messages, to the bit. */
#include "trws.h"

#include <string.h>

#include "../base/minmax.h"
#include "trws_visit.h"

typedef struct sweep {
    const qs_trws_state *state;
    uint32_t labels;
    /* Of each label of each site: the costs of its row up to the site, and those of its column. In
     * `row` the marginals will be. */
    qs_number *row, *column;
    /* Of the sweep back: the costs of what comes later, on the row and on each column. */
    qs_number *row_later, *column_later;
    qs_number *costs; /* to be sent */
} sweep;

/* Rows of `labels` numbers: of this file, and of trws_graph.c. */
static uint64_t row_count(const qs_model *model)
{
    return model->width > 0 ? 2 * (uint64_t)model->sites + model->width + 2
                            : (uint64_t)model->sites + model->edges + 2;
}

uint64_t qs_trws_marginal_numbers(const qs_model *model)
{
    return row_count(model) * model->labels;
}

static sweep lay_out(const qs_trws_state *state, qs_natural *marginals)
{
    const qs_model *model = state->model;
    size_t labels = model->labels, all = model->sites * labels;
    sweep s = {.state = state, .row = (qs_number *)marginals, .labels = model->labels};
    s.column = s.row + all;
    s.row_later = s.column + all;
    s.column_later = s.row_later + labels;
    s.costs = s.column_later + model->width * labels;
    return s;
}

/* Sends costs that must stay as they are to a later site. */
static qs_number send(const sweep *s, uint32_t edge, qs_number weight, const qs_number *costs,
                      qs_number *message)
{
    memcpy(s->costs, costs, sizeof *costs * s->labels);
    return qs_message_send(s->state->model, edge, weight, true, s->costs, message,
                           s->state->scratch);
}

static void forward(const sweep *s, int64_t *shares)
{
    const qs_trws_state *state = s->state;
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        uint32_t p = qs_trws_site(state, at, true);
        qs_number *row = s->row + (size_t)p * s->labels,
                  *column = s->column + (size_t)p * s->labels;
        qs_visit v = qs_visit_of(state, p, s->labels, true);
        qs_visit_charge(state, &v, s->labels, row, column);
        shares[p] = send(s, v.row_edge, v.row_weight, row, v.row_out);
        shares[p] += send(s, v.column_edge, v.column_weight, column, v.column_out);
    }
}

/* One chain at a site. Its costs up to the site and those of what comes later make the
 * min-marginals. The costs from the site on go back to the site before it.
 *
 * costs   the costs up to the site; out: the min-marginals, less their least
 * later   the costs of what comes later; out: the same for the site before
 * came    the message that came along the chain: it has the costs before the site
 * edge    the number of the edge to the site before
 * weight  of that edge, scaled */
static void sweep_chain(const sweep *s, qs_number *costs, qs_number *later, const qs_number *came,
                        uint32_t edge, qs_number weight)
{
    qs_number least = QS_NUMBER_MAX;
    for (uint32_t d = 0; d < s->labels; d++) {
        costs[d] += later[d];
        s->costs[d] = costs[d] - came[d];
        least = qs_min_number(least, costs[d]);
    }
    for (uint32_t d = 0; d < s->labels; d++) {
        costs[d] -= least;
    }
    (void)qs_message_send(s->state->model, edge, weight, false, s->costs, later, s->state->scratch);
}

/* Where a chain ends no cost comes later: nothing was sent there, along an edge of weight 0. */
static void back(const sweep *s)
{
    const qs_model *model = s->state->model;
    uint32_t labels = s->labels;
    memset(s->row_later, 0, sizeof *s->row_later * labels * (model->width + (size_t)1));
    for (uint32_t at = 0; at < qs_trws_visits(s->state) && qs_trws_going(s->state, at); at++) {
        uint32_t p = qs_trws_site(s->state, at, false);
        qs_visit v = qs_visit_of(s->state, p, labels, false); /* its `out` = to the sites before */
        qs_number *row = s->row + (size_t)p * labels, *column = s->column + (size_t)p * labels;
        sweep_chain(s, row, s->row_later, v.row_out, v.row_edge, v.row_weight);
        sweep_chain(s, column, s->column_later + (size_t)(p % model->width) * labels, v.column_out,
                    v.column_edge, v.column_weight);
        qs_natural *marginals = (qs_natural *)row;
        for (uint32_t d = 0; d < labels; d++) {
            marginals[d] += (qs_natural)column[d];
        }
    }
}

void qs_trws_grid_marginals(const qs_trws_state *state, qs_natural *marginals, int64_t *shares)
{
    sweep s = lay_out(state, marginals);
    forward(&s, shares);
    back(&s);
}
