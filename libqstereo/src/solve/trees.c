#include "trees.h"

#include <string.h>

#include "../base/random.h"
#include "../base/sets.h"
#include "../model/neighbours.h"

#define NONE UINT32_MAX

enum { SKIPPED = 8 }; /* one site in so many stays outside, so that forests differ */

void qs_trees_take(qs_trees *t, const qs_model *model, qs_arena *arena)
{
    uint64_t sites = model->sites;
    t->model = model;
    t->tree = qs_arena_take(arena, sites, sizeof *t->tree);
    t->degree = qs_arena_take(arena, sites, sizeof *t->degree);
    t->order = qs_arena_take(arena, sites, sizeof *t->order);
    t->towards = qs_arena_take(arena, sites, sizeof *t->towards);
    t->costs = qs_arena_take(arena, sites * model->labels, sizeof *t->costs);
    t->scratch = qs_arena_take(arena, 2 * (uint64_t)model->labels + qs_message_scratch(model),
                               sizeof *t->scratch);
}

void qs_trees_begin(qs_trees *t)
{
    (void)qs_scale_choose(t->model, 0, &t->scale);
    memset(t->tree, 0xff, sizeof *t->tree * t->model->sites); /* NONE */
}

static bool is_in(const qs_trees *t, uint32_t site)
{
    return t->tree[site] != NONE;
}

/* Whether two edges of a site lead to the same tree. Each tree that one leads to is marked at the
 * site that stands for it: the sites of a forest that is being drawn have no degrees yet. */
static bool makes_circle(qs_trees *t, uint32_t p)
{
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(t->model, p, at, &edge); at++) {
        if (edge.weight > 0 && is_in(t, edge.site)) {
            uint32_t *mark = &t->degree[qs_set_of(t->tree, edge.site)];
            if (*mark == p + 1) {
                return true;
            }
            *mark = p + 1;
        }
    }
    return false;
}

/* A site comes into the forest if that makes no circle. */
static void offer(qs_trees *t, uint32_t p)
{
    qs_edge_seen edge;
    if (makes_circle(t, p)) {
        return;
    }
    t->tree[p] = p;
    t->degree[p] = 0;
    for (uint32_t at = 0; qs_see_edge(t->model, p, at, &edge); at++) {
        if (edge.weight > 0 && is_in(t, edge.site)) {
            qs_set_join(t->tree, p, edge.site);
        }
    }
}

static void draw_forest(qs_trees *t, const uint32_t *sites, uint32_t count, uint64_t *random)
{
    bool back = qs_draw(random) & 1;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = back ? count - 1 - i : i, p = sites ? sites[at] : at;
        if (qs_draw_below(random, SKIPPED) > 0) {
            offer(t, p);
        }
    }
}

/* What each label of a site costs beside the sites outside the forest. */
static void load(qs_trees *t, uint32_t p, const uint16_t *labelling)
{
    const qs_model *model = t->model;
    size_t first = (size_t)p * model->labels;
    qs_number *costs = t->costs + first;
    qs_edge_seen edge;
    t->degree[p] = 0;
    for (uint32_t d = 0; d < model->labels; d++) {
        costs[d] = qs_scaled_cost(model, t->scale, first + d);
    }
    for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
        if (edge.weight > 0 && is_in(t, edge.site)) {
            t->degree[p]++;
        } else {
            qs_message_pay(model, edge.edge, edge.weight, !edge.first, labelling[edge.site], costs);
        }
    }
}

/* Sends a leaf's message to the one neighbour in the forest that is not done. */
static void send(qs_trees *t, uint32_t p, const qs_edge_seen *edge)
{
    const qs_model *model = t->model;
    uint32_t labels = model->labels;
    qs_number *own = t->scratch, *message = own + labels, *rest = message + labels,
              *costs = t->costs + (size_t)edge->site * labels;
    memcpy(own, t->costs + (size_t)p * labels, sizeof *own * labels);
    (void)qs_message_send(model, edge->edge, edge->weight, edge->first, own, message, rest);
    for (uint32_t d = 0; d < labels; d++) {
        costs[d] += message[d];
    }
}

/* A leaf is done. Returns the neighbour that has become a leaf by that, or NONE. */
static uint32_t finish(qs_trees *t, uint32_t p)
{
    qs_edge_seen edge;
    bool last = t->degree[p] == 0;
    t->degree[p] = NONE;
    t->towards[p] = NONE;
    for (uint32_t at = 0; !last && qs_see_edge(t->model, p, at, &edge); at++) {
        if (edge.weight > 0 && is_in(t, edge.site) && t->degree[edge.site] != NONE) {
            t->towards[p] = at;
            send(t, p, &edge);
            return --t->degree[edge.site] == 1 ? edge.site : NONE;
        }
    }
    return NONE;
}

/* The cheapest label; of equals the first one from `from` on. */
static uint16_t cheapest(const qs_number *costs, uint32_t labels, uint32_t from)
{
    uint32_t best = from;
    for (uint32_t i = 1, d = from; i < labels; i++) {
        d = d + 1 < labels ? d + 1 : 0;
        best = costs[d] < costs[best] ? d : best;
    }
    return (uint16_t)best;
}

static void choose(qs_trees *t, uint32_t p, uint32_t from, uint16_t *labelling)
{
    const qs_model *model = t->model;
    qs_number *costs = t->costs + (size_t)p * model->labels;
    qs_edge_seen edge;
    if (t->towards[p] != NONE) {
        (void)qs_see_edge(model, p, t->towards[p], &edge);
        qs_message_pay(model, edge.edge, edge.weight, !edge.first, labelling[edge.site], costs);
    }
    labelling[p] = cheapest(costs, model->labels, from);
}

void qs_trees_move(qs_trees *t, const uint32_t *sites, uint32_t count, uint64_t *random,
                   uint16_t *labelling)
{
    uint32_t all = sites ? count : t->model->sites, done = 0, known = 0;
    uint32_t from = qs_draw_below(random, t->model->labels);
    draw_forest(t, sites, all, random);
    for (uint32_t i = 0; i < all; i++) {
        uint32_t p = sites ? sites[i] : i;
        if (is_in(t, p)) {
            load(t, p, labelling);
            if (t->degree[p] < 2) {
                t->order[known++] = p;
            }
        }
    }
    for (; done < known; done++) {
        uint32_t next = finish(t, t->order[done]);
        if (next != NONE) {
            t->order[known++] = next;
        }
    }
    while (done > 0) {
        choose(t, t->order[--done], from, labelling);
    }
    t->count = known;
    for (uint32_t i = 0; i < known; i++) {
        t->tree[t->order[i]] = NONE;
    }
}
