/* TRW-S on lists of neighbours: the chains go through each site from its i-th earlier edge to its i-th later one; where the numbers differ, some
 * begin or end there. */
#include "trws.h"

#include <string.h>

#include "lanes.h"

/* A site's edges to earlier and later sites, of weight above 0. */
static void count_chains(const qs_model *model, uint32_t site, uint32_t *lower, uint32_t *higher)
{
    *lower = *higher = 0;
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        if (model->links[n].weight > 0) {
            ++*(model->links[n].site < site ? lower : higher);
        }
    }
}

static int32_t *message_of(const qs_trws_state *state, const qs_link *link)
{
    return state->messages + (size_t)link->edge * state->model->labels;
}

/* All that is charged at a site: its unary costs and the messages to it. */
static void add_all(const qs_trws_state *state, uint32_t site, int32_t *total)
{
    const qs_model *model = state->model;
    const int32_t *unary = model->unary + (size_t)site * model->labels;
    for (uint32_t d = 0; d < model->labels; d++) {
        total[d] = qs_min32(unary[d], state->scale.most) << state->scale.shift;
    }
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const int32_t *message = message_of(state, &model->links[n]);
        for (uint32_t d = 0; model->links[n].weight > 0 && d < model->labels; d++) {
            total[d] += message[d];
        }
    }
}

/* The i-th of n whole parts of each cost; all n make the cost, whatever its sign. */
static void take_part(const int32_t *total, uint32_t labels, uint32_t i, uint32_t n, int32_t *part)
{
    int32_t parts = (int32_t)n, at = (int32_t)i;
    for (uint32_t d = 0; d < labels; d++) {
        int32_t rest = total[d] % parts;
        part[d] = total[d] / parts + (at < rest) - (at < -rest);
    }
}

static int32_t least_part(const int32_t *part, uint32_t labels)
{
    int32_t least = part[0];
    for (uint32_t d = 1; d < labels; d++) {
        least = qs_min32(least, part[d]);
    }
    return least;
}

static int64_t visit(const qs_trws_state *state, uint32_t site, bool forward)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels, lower, higher, sent = 0;
    int32_t *total = state->scratch, *part = total + labels, *rest = part + labels;
    count_chains(model, site, &lower, &higher);
    uint32_t chains = lower > higher ? lower : higher;
    chains = chains > 0 ? chains : 1;
    add_all(state, site, total);
    int64_t bound = 0;
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const qs_link *link = &model->links[n];
        if (link->weight == 0 || (link->site > site) != forward) {
            continue;
        }
        int32_t *message = message_of(state, link);
        take_part(total, labels, sent++, chains, part);
        for (uint32_t d = 0; d < labels; d++) {
            part[d] -= message[d];
        }
        bound += qs_message_send(model, link->weight << state->scale.shift, forward, part, message, rest);
    }
    for (; sent < chains; sent++) { /* the chains that end here */
        take_part(total, labels, sent, chains, part);
        bound += least_part(part, labels);
    }
    return bound;
}

int64_t qs_trws_graph_pass(const qs_trws_state *state, bool forward)
{
    int64_t bound = 0;
    for (uint32_t at = 0; at < state->model->sites; at++) {
        bound += visit(state, forward ? at : state->model->sites - 1 - at, forward);
    }
    return bound;
}

/* A site's costs beside the labels of its earlier neighbours and the messages of the later ones. */
static void add_around(const qs_trws_state *state, uint32_t site, bool forward, const uint16_t *labelling, int32_t *costs)
{
    const qs_model *model = state->model;
    const int32_t *unary = model->unary + (size_t)site * model->labels;
    for (uint32_t d = 0; d < model->labels; d++) {
        costs[d] = qs_min32(unary[d], state->scale.most) << state->scale.shift;
    }
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const qs_link *link = &model->links[n];
        if ((link->site < site) == forward) {
            qs_message_pay(model, link->weight << state->scale.shift, forward, labelling[link->site], costs);
            continue;
        }
        const int32_t *message = message_of(state, link);
        for (uint32_t d = 0; link->weight > 0 && d < model->labels; d++) {
            costs[d] += message[d];
        }
    }
}

void qs_trws_graph_labels(const qs_trws_state *state, bool forward, uint16_t *labelling)
{
    const qs_model *model = state->model;
    int32_t *costs = state->scratch;
    for (uint32_t at = 0; at < model->sites; at++) {
        uint32_t p = forward ? at : model->sites - 1 - at, best = 0;
        add_around(state, p, forward, labelling, costs);
        for (uint32_t d = 1; d < model->labels; d++) {
            best = costs[d] < costs[best] ? d : best;
        }
        labelling[p] = (uint16_t)best;
    }
}
