/* TRW-S on general graphs. The chains go through each site from its i-th edge to an earlier site to
 * its i-th edge to a later one. Where there are more of the one kind, some begin or end there. */
#include "trws_passes.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"

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

static qs_number *message_of(const qs_trws_state *state, const qs_link *link)
{
    return state->messages + (size_t)link->edge * state->model->labels;
}

static void add_message(const qs_trws_state *state, const qs_link *link, qs_number *costs)
{
    const qs_number *message = message_of(state, link);
    for (uint32_t d = 0; d < state->model->labels; d++) {
        costs[d] += message[d];
    }
}

/* The unary costs of a site and the messages to it. */
static void add_all(const qs_trws_state *state, uint32_t site, qs_number *total)
{
    const qs_model *model = state->model;
    size_t first = (size_t)site * model->labels;
    for (uint32_t d = 0; d < model->labels; d++) {
        total[d] = qs_scaled_cost(model, state->scale, first + d);
    }
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        if (model->links[n].weight > 0) {
            add_message(state, &model->links[n], total);
        }
    }
}

/* The i-th of n whole parts of each cost. The n parts add up to the cost, whatever its sign. */
static void take_part(const qs_number *total, uint32_t labels, uint32_t i, uint32_t n,
                      qs_number *part)
{
    qs_number parts = (qs_number)n, at = (qs_number)i;
    for (uint32_t d = 0; d < labels; d++) {
        qs_number rest = total[d] % parts;
        part[d] = total[d] / parts + (at < rest) - (at < -rest);
    }
}

/* What a forward pass leaves for the sweep back. */
typedef struct record {
    qs_number *total; /* of each site: what was charged there */
    qs_number *replaced; /* of each edge: the message that was replaced */
} pass_record;

static int64_t visit(const qs_trws_state *state, uint32_t site, bool forward,
                     const pass_record *record)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels, lower, higher, sent = 0;
    qs_number *total = state->scratch, *part = total + labels, *rest = part + labels;
    count_chains(model, site, &lower, &higher);
    uint32_t chains = lower > higher ? lower : higher;
    chains = chains > 0 ? chains : 1;
    add_all(state, site, total);
    if (record) {
        memcpy(record->total + (size_t)site * labels, total, sizeof *total * labels);
    }
    int64_t bound = 0;
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const qs_link *link = &model->links[n];
        if (link->weight == 0 || (link->site > site) != forward) {
            continue;
        }
        qs_number *message = message_of(state, link);
        if (record) {
            memcpy(record->replaced + (size_t)link->edge * labels, message,
                   sizeof *message * labels);
        }
        take_part(total, labels, sent++, chains, part);
        for (uint32_t d = 0; d < labels; d++) {
            part[d] -= message[d];
        }
        bound += qs_message_send(model, link->edge, qs_scaled_weight(state->scale, link->weight),
                                 forward, part, message, rest);
    }
    for (; sent < chains; sent++) { /* the chains that end here */
        take_part(total, labels, sent, chains, part);
        bound += qs_least(part, labels);
    }
    return bound;
}

int64_t qs_trws_graph_pass(const qs_trws_state *state, bool forward)
{
    int64_t bound = 0;
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        bound += visit(state, qs_trws_site(state, at, forward), forward, NULL);
    }
    return bound;
}

/* The next link from `at` on of weight above 0. */
static uint32_t next_link(const qs_model *model, uint32_t at, uint32_t end)
{
    while (at < end && model->links[at].weight == 0) {
        at++;
    }
    return at;
}

/* One chain at a site. Adds its min-marginals, less the least, to the marginals; then sends the
 * costs from the site on back along the edge before it. The record has, for the edge after it, the
 * costs of what comes later, less the message that was replaced.
 *
 * before, after  the chain's edges at the site; NULL = it begins or ends here
 * part           what the chain was charged here; overwritten */
static void sweep_chain(const qs_trws_state *state, const pass_record *record,
                        const qs_link *before, const qs_link *after, qs_number *part,
                        qs_natural *marginals)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels;
    if (after) {
        const qs_number *later = record->replaced + (size_t)after->edge * labels;
        for (uint32_t d = 0; d < labels; d++) {
            part[d] += later[d];
        }
    }
    qs_number least = qs_least(part, labels);
    for (uint32_t d = 0; d < labels; d++) {
        qs_natural more = (qs_natural)part[d] - (qs_natural)least;
        marginals[d] = more < QS_NATURAL_MAX - marginals[d] ? marginals[d] + more : QS_NATURAL_MAX;
    }
    if (before) {
        const qs_number *came = message_of(state, before);
        qs_number *message = state->scratch, *rest = message + labels,
                  *replaced = record->replaced + (size_t)before->edge * labels;
        for (uint32_t d = 0; d < labels; d++) {
            part[d] -= came[d];
        }
        (void)qs_message_send(model, before->edge, qs_scaled_weight(state->scale, before->weight),
                              false, part, message, rest);
        for (uint32_t d = 0; d < labels; d++) {
            replaced[d] = message[d] - replaced[d];
        }
    }
}

/* All chains through a site. In the record the marginals take the place of what was charged there.
 *
 * work  memory for two numbers a label */
static void sweep_site(const qs_trws_state *state, uint32_t site, const pass_record *record,
                       qs_number *work)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels, lower, higher, end = model->link_start[site + 1];
    uint32_t before = next_link(model, model->link_start[site], end), after = before;
    count_chains(model, site, &lower, &higher);
    uint32_t chains = lower > higher ? lower : higher;
    chains = chains > 0 ? chains : 1;
    for (uint32_t i = 0; i < lower; i++) {
        after = next_link(model, after + 1, end);
    }
    qs_number *part = work, *total = record->total + (size_t)site * labels;
    qs_natural *marginals = (qs_natural *)work + labels;
    memset(marginals, 0, sizeof *marginals * labels);
    for (uint32_t i = 0; i < chains; i++) {
        take_part(total, labels, i, chains, part);
        sweep_chain(state, record, i < lower ? &model->links[before] : NULL,
                    i < higher ? &model->links[after] : NULL, part, marginals);
        before = next_link(model, before + 1, end);
        after = next_link(model, after + 1, end);
    }
    memcpy(total, marginals, sizeof *marginals * labels);
}

void qs_trws_graph_marginals(const qs_trws_state *state, qs_natural *marginals, int64_t *shares)
{
    const qs_model *model = state->model;
    pass_record record = {(qs_number *)marginals,
                          (qs_number *)marginals + (size_t)model->sites * model->labels};
    qs_number *work = record.replaced + (size_t)model->edges * model->labels;
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        uint32_t p = qs_trws_site(state, at, true);
        shares[p] = visit(state, p, true, &record);
    }
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        sweep_site(state, qs_trws_site(state, at, false), &record, work);
    }
}

static void split_site(const qs_trws_state *state, const qs_witness *witness, uint32_t site)
{
    const qs_model *model = state->model;
    uint32_t labels = model->labels, lower, higher, end = model->link_start[site + 1];
    qs_number *total = state->scratch, *part = total + labels, *rest = part + labels;
    uint32_t before = next_link(model, model->link_start[site], end), after = before;
    count_chains(model, site, &lower, &higher);
    uint32_t chains = lower > higher ? lower : higher;
    for (uint32_t i = 0; i < lower; i++) {
        after = next_link(model, after + 1, end);
    }
    add_all(state, site, total);
    for (uint32_t i = 0; i < chains; i++) {
        const qs_number *came = i < lower ? message_of(state, &model->links[before]) : NULL;
        qs_number *sent = i < higher ? message_of(state, &model->links[after]) : NULL;
        take_part(total, labels, i, chains, part);
        for (uint32_t d = 0; d < labels; d++) {
            part[d] -= (came ? came[d] : 0) + (sent ? sent[d] : 0);
        }
        witness->share(witness->context, model, site, i, part, sizeof *part);
        for (uint32_t d = 0; d < labels && came; d++) {
            part[d] += came[d];
        }
        if (sent) {
            const qs_link *link = &model->links[after];
            (void)qs_message_send(model, link->edge, qs_scaled_weight(state->scale, link->weight),
                                  true, part, sent, rest);
        }
        before = next_link(model, before + 1, end);
        after = next_link(model, after + 1, end);
    }
}

void qs_trws_graph_split(const qs_trws_state *state, const qs_witness *witness)
{
    for (uint32_t at = 0; at < qs_trws_visits(state); at++) {
        split_site(state, witness, qs_trws_site(state, at, true));
    }
}

/* What each label of a site costs, given the labels of its earlier neighbours and the messages from
 * the later ones. */
static void add_around(const qs_trws_state *state, uint32_t site, bool forward,
                       const uint16_t *labelling, qs_number *costs)
{
    const qs_model *model = state->model;
    size_t first = (size_t)site * model->labels;
    for (uint32_t d = 0; d < model->labels; d++) {
        costs[d] = qs_scaled_cost(model, state->scale, first + d);
    }
    for (uint32_t n = model->link_start[site]; n < model->link_start[site + 1]; n++) {
        const qs_link *link = &model->links[n];
        if ((link->site < site) == forward) {
            qs_message_pay(model, link->edge, qs_scaled_weight(state->scale, link->weight), forward,
                           labelling[link->site], costs);
        } else if (link->weight > 0) {
            add_message(state, link, costs);
        }
    }
}

void qs_trws_graph_labels(const qs_trws_state *state, bool forward, uint16_t *labelling)
{
    const qs_model *model = state->model;
    qs_number *costs = state->scratch;
    for (uint32_t at = 0; at < model->sites && qs_trws_going(state, at); at++) {
        uint32_t p = forward ? at : model->sites - 1 - at;
        add_around(state, p, forward, labelling, costs);
        labelling[p] = (uint16_t)qs_least_at(costs, model->labels);
    }
}
