#include "probes.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/sort.h"
#include "../model/neighbours.h"
#include "../solve/trws_split.h"
#include "parts.h"

enum {
    NODES = 4096, /* open sites at most */
    FEWEST = 4, /* iterations of a trial, and from then on as long as each brings it nearer by */
    STEP = 16, /* a STEP-th of what is missing */
    WIDE = 1 << 30
};

/* The part that trials are made in. */
typedef struct trial {
    qs_probes *probes;
    qs_elimination *e;
    qs_trws_state *state;
    uint32_t *all; /* the sites of a part as it was in the beginning, in order, */
    uint32_t all_count;
    uint32_t *turn; /* the same in the order of trials */
    uint32_t *sites; /* and of the part of them that is visited */
    uint32_t count;
    bool is_current; /* they are what edges join now */
    qs_number *kept_messages, *before; /* of the part: those to come back to, and of a pass */
    int32_t *unary; /* of the site that is tried */
    qs_arena arena;
} trial;

/* Copies the messages of the part's edges. Each edge is its first site's. Returns how many numbers
 * these are.
 *
 * copy  NULL = only counts them
 * back  from the copy */
static size_t copy_messages(const trial *t, qs_number *copy, bool back)
{
    const qs_model *model = &t->e->model;
    size_t labels = model->labels, at = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        qs_edge_seen edge;
        for (uint32_t n = 0; qs_see_edge(model, t->sites[i], n, &edge); n++) {
            if (edge.first && edge.weight > 0) {
                qs_number *own = t->state->messages + edge.edge * labels;
                if (copy) {
                    memcpy(back ? own : copy + at, back ? copy + at : own, sizeof *own * labels);
                }
                at += labels;
            }
        }
    }
    return at;
}

/* Lists the sites of the part of a site, in order. Returns how many; more than NODES = too many. */
static uint32_t list_part(const qs_elimination *e, uint32_t site, uint32_t *sites)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < e->left_count && count <= NODES; i++) {
        if (e->part[e->left[i]] == e->part[site]) {
            if (count < NODES) {
                sites[count] = e->left[i];
            }
            count++;
        }
    }
    return count;
}

/* How many costs a table of a site and its neighbours has: what keeps a part from being narrow. */
static uint64_t width_at(const qs_elimination *e, uint32_t site)
{
    uint64_t width = qs_eliminate_count(e, site);
    qs_edge_seen edge;
    for (uint32_t n = 0; qs_see_edge(&e->model, site, n, &edge); n++) {
        width *= edge.weight > 0 && width < WIDE ? qs_eliminate_count(e, edge.site) : 1;
    }
    return width;
}

static bool is_wider(const void *context, uint32_t a, uint32_t b)
{
    return width_at(context, a) > width_at(context, b);
}

/* Begins with a part. Returns false if it is too large. */
static bool begin_part(trial *t, uint32_t site)
{
    uint32_t most = qs_min_u32(t->e->model.sites, NODES);
    t->arena = (qs_arena){.base = t->probes->memory};
    t->all = qs_arena_take(&t->arena, most, sizeof *t->all);
    t->turn = qs_arena_take(&t->arena, most, sizeof *t->turn);
    t->sites = qs_arena_take(&t->arena, most, sizeof *t->sites);
    t->unary = qs_arena_take(&t->arena, t->e->model.labels, sizeof *t->unary);
    if (qs_arena_size(&t->arena) > t->probes->size) {
        return false;
    }
    t->is_current = false;
    t->all_count = list_part(t->e, site, t->all);
    if (t->all_count > NODES) {
        return false;
    }
    memcpy(t->turn, t->all, sizeof *t->all * t->all_count);
    qs_sort(t->turn, t->sites, t->all_count, is_wider, t->e);
    return true;
}

/* Makes passes visit the part of a site alone. Returns false if there is too little memory. */
static bool visit_part(trial *t, uint32_t site)
{
    qs_arena arena = t->arena;
    t->count = list_part(t->e, site, t->sites);
    qs_trws_visit_only(t->state, t->sites, t->count);
    size_t numbers = copy_messages(t, NULL, false);
    t->kept_messages = qs_arena_take(&arena, numbers, sizeof *t->kept_messages);
    t->before = qs_arena_take(&arena, numbers, sizeof *t->before);
    t->is_current = qs_arena_size(&arena) <= t->probes->size;
    if (t->is_current) {
        (void)copy_messages(t, t->kept_messages, false);
    }
    return t->is_current;
}

static int64_t pass(const qs_trws_state *state, bool forward)
{
    return state->model->width > 0 ? qs_trws_grid_pass(state, forward)
                                   : qs_trws_graph_pass(state, forward);
}

static bool is_stopped(const trial *t)
{
    return t->state->look && t->state->look->stopped;
}

/* Iterates until the bound is above `limit`. Then the messages are those before the forward pass
 * that found it. Returns false if it does not get there. */
static bool rises_above(trial *t, int64_t limit)
{
    uint64_t numbers = 2 * (uint64_t)t->count * qs_trws_work(&t->e->model);
    int64_t missing = INT64_MAX;
    for (uint32_t i = 0; t->probes->work->left > 0; i++) {
        (void)copy_messages(t, t->before, false);
        int64_t bound = pass(t->state, true);
        (void)qs_spend(t->probes->work, numbers);
        if (is_stopped(t)) {
            return false;
        }
        if (bound > limit) {
            (void)copy_messages(t, t->before, true);
            return true;
        }
        if (i >= FEWEST && limit - bound >= missing - missing / STEP) {
            return false;
        }
        missing = limit - bound;
        (void)pass(t->state, false);
    }
    return false;
}

/* Leaves a site one label. The costs of the others are those of labels that are out. */
static void hold(trial *t, uint32_t site, uint32_t label)
{
    uint32_t labels = t->e->model.labels;
    int32_t *unary = t->e->unary + (size_t)site * labels;
    int64_t above = (int64_t)unary[label] + qs_most_of_edges(&t->e->model, site) + 1;
    memcpy(t->unary, unary, sizeof *unary * labels);
    for (uint32_t d = 0; d < labels; d++) {
        unary[d] = d == label ? unary[d] : (int32_t)qs_min_i64(above, INT32_MAX);
    }
}

static void let_go(trial *t, uint32_t site)
{
    uint32_t labels = t->e->model.labels;
    memcpy(t->e->unary + (size_t)site * labels, t->unary, sizeof *t->unary * labels);
}

/* What the labelling costs in the part. */
static int64_t energy_of(const trial *t)
{
    int64_t energy = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        energy += qs_eliminate_cost_at(t->e, t->sites[i]);
    }
    return energy;
}

/* Tries a label. Returns true if it leaves. */
static bool try_label(trial *t, uint32_t site, uint32_t label)
{
    qs_elimination *e = t->e;
    const qs_witness *witness = t->probes->witness;
    int64_t limit = energy_of(t) * ((int64_t)1 << t->state->scale.shift);
    hold(t, site, label);
    bool leaves = rises_above(t, limit);
    if (leaves && witness) {
        qs_trws_split(t->state, e->labelling, witness);
    }
    let_go(t, site);
    (void)copy_messages(t, t->kept_messages, true);
    if (leaves) {
        e->kept[(size_t)site * e->model.labels + label] = 0;
        if (witness) {
            witness->end(witness->context, e->kept);
        }
        qs_eliminate_follow_set(e, site);
        qs_eliminate_follow(e);
    }
    if (leaves && witness) {
        witness->end(witness->context, e->kept);
    }
    return leaves;
}

static bool is_open(const qs_elimination *e, uint32_t site, uint32_t label)
{
    return e->labelling[site] != label && e->kept[(size_t)site * e->model.labels + label];
}

/* Tries the next labels of a site but that of the labelling, until one leaves. Returns false if
 * none does. */
static bool try_site(trial *t, uint32_t site, uint32_t *label)
{
    bool leaves = false;
    for (; *label < t->e->model.labels && !leaves && t->probes->work->left > 0 && !is_stopped(t);
         ++*label) {
        leaves = is_open(t->e, site, *label) && try_label(t, site, *label);
    }
    t->is_current = t->is_current && !leaves;
    return leaves;
}

/* Makes passes visit the part of a site, if they do not yet, and if it is open. */
static bool is_visited(trial *t, uint32_t site)
{
    const qs_elimination *e = t->e;
    if (e->closed[site] || !qs_eliminate_has_edges(e, site)) {
        return false;
    }
    return (t->is_current && e->part[site] == e->part[t->sites[0]]) || visit_part(t, site);
}

/* The parts that the part has become are solved where they are narrow enough by now. */
static void solve_what_is_left(trial *t)
{
    const qs_elimination *e = t->e;
    size_t used = qs_arena_size(&t->arena);
    void *memory = (char *)t->probes->memory + used;
    for (uint32_t i = 0, n = 0; i < e->left_count && n < t->all_count; i++) {
        while (n < t->all_count && t->all[n] < e->left[i]) {
            n++;
        }
        if (n < t->all_count && t->all[n] == e->left[i]) {
            (void)qs_parts_solve_one(t->e, i, memory, t->probes->size - used, t->probes->work,
                                     t->probes->witness);
        }
    }
    qs_eliminate_follow(t->e);
    qs_eliminate_find_parts(t->e);
    t->is_current = false;
}

/* Tries the sites of the part that has been begun with. Returns true if anything has changed. */
static bool try_part(trial *t)
{
    bool changed = false;
    for (uint32_t i = 0; i < t->all_count && t->probes->work->left > 0 && !is_stopped(t); i++) {
        uint32_t label = 0;
        bool leaves = false;
        while (t->probes->most > 0 && is_visited(t, t->turn[i]) &&
               try_site(t, t->turn[i], &label)) {
            t->probes->most--;
            qs_eliminate_find_parts(t->e);
            leaves = true;
        }
        if (leaves) {
            solve_what_is_left(t);
        }
        changed = changed || leaves;
    }
    return changed;
}

/* A stage of a proof is of all sites that are open: they must be few. */
static bool are_few(const qs_elimination *e)
{
    uint32_t open = 0;
    for (uint32_t i = 0; i < e->left_count; i++) {
        open += !e->closed[e->left[i]];
    }
    return open <= NODES;
}

bool qs_probes_take_out(qs_probes *probes)
{
    qs_elimination *e = probes->e;
    qs_trws_state *state = probes->state;
    trial t = {.probes = probes, .e = e, .state = state};
    bool all = state->visits == NULL, changed = false;
    if (!are_few(e)) {
        return false;
    }
    qs_eliminate_find_parts(e);
    for (uint32_t p = 0; p < e->model.sites && probes->work->left > 0 && !is_stopped(&t); p++) {
        bool is_first = qs_eliminate_has_edges(e, p) && e->part[p] == p;
        if (is_first && !e->closed[p] && begin_part(&t, p)) {
            changed = try_part(&t) || changed;
        }
    }
    qs_trws_visit_only(state, e->left, e->left_count);
    state->visits = all ? NULL : e->left;
    return changed;
}
