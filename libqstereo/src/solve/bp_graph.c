#include "bp.h"

#include "../base/minmax.h"
#include "../base/simd.h"

/* The message along a link of a site: to that site, or from it. */
static qs_number *message_of(const qs_bp_state *state, uint32_t site, const qs_link *link,
                             bool to_site)
{
    bool upward = (link->site < site) == to_site;
    return state->messages + (2 * (size_t)link->edge + !upward) * state->model->labels;
}

/* What each label of a site costs: its unary cost and all messages to it. */
static void believe(const qs_bp_state *state, uint32_t site, qs_number *belief)
{
    const qs_model *model = state->model;
    size_t first = (size_t)site * model->labels;
    for (uint32_t d = 0; d < model->labels; d++) {
        belief[d] = qs_scaled_cost(model, state->scale, first + d);
    }
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const qs_number *message = message_of(state, site, &model->links[n], true);
        for (uint32_t d = 0; d < model->labels; d++) {
            belief[d] += message[d];
        }
    }
}

/* Sends to the neighbours that come later in the sweep. */
static void send(const qs_bp_state *state, uint32_t site, bool upward)
{
    const qs_model *model = state->model;
    qs_number *belief = state->scratch, *costs = belief + model->labels,
              *rest = costs + model->labels;
    believe(state, site, belief);
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const qs_link *link = &model->links[n];
        if ((link->site > site) != upward) {
            continue;
        }
        const qs_number *back = message_of(state, site, link, true);
        for (uint32_t d = 0; d < model->labels; d++) {
            costs[d] = belief[d] - back[d];
        }
        qs_bp_send(state, link->edge, qs_scaled_weight(state->scale, link->weight), upward, costs,
                   message_of(state, site, link, false), rest);
    }
}

void qs_bp_graph_sweep(const qs_bp_state *state)
{
    for (uint32_t p = 0; p < state->model->sites && qs_bp_going(state, p); p++) {
        send(state, p, true);
    }
    for (uint32_t p = state->model->sites; p-- > 0 && qs_bp_going(state, p);) {
        send(state, p, false);
    }
}

/* Each site in order takes its cheapest label: by its belief, but with the labels of its earlier
 * neighbours in place of their messages. */
void qs_bp_graph_labels(const qs_bp_state *state, uint16_t *labelling)
{
    const qs_model *model = state->model;
    qs_number *costs = state->scratch;
    for (uint32_t p = 0; p < model->sites && qs_bp_going(state, p); p++) {
        believe(state, p, costs);
        for (uint32_t n = model->link_start[p];
             n < model->link_start[p + 1] && model->links[n].site < p; n++) {
            const qs_link *link = &model->links[n];
            const qs_number *message = message_of(state, p, link, true);
            for (uint32_t d = 0; d < model->labels; d++) {
                costs[d] -= message[d];
            }
            qs_message_pay(model, link->edge, qs_scaled_weight(state->scale, link->weight), true,
                           labelling[link->site], costs);
        }
        labelling[p] = (uint16_t)qs_least_at(costs, model->labels);
    }
}
