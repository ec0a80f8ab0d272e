#include "trws.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/simd.h"
#include "../model/neighbours.h"
#include "progress.h"
#include "solve_64.h"
#include "trws_split.h"

enum { DEFAULT_ITERATIONS = 500, FINEST = 14, LABELS_EVERY = 8 };

/* Hands out the workspace, or counts it. Returns its size.
 *
 * trial  out: a labelling */
static size_t take_parts(qs_trws_state *state, void *workspace, uint16_t **trial)
{
    const qs_model *model = state->model;
    qs_arena arena = {.base = workspace};
    uint64_t padding = qs_trws_padding(model);
    qs_number *padded = qs_arena_take(&arena, padding + qs_trws_messages(model), sizeof *padded);
    state->messages = padded ? padded + padding : NULL;
    state->scratch = qs_arena_take(&arena, qs_trws_scratch(model), sizeof *state->scratch);
    *trial = qs_arena_take(&arena, model->sites, sizeof **trial);
    return qs_arena_size(&arena);
}

size_t qs_trws_workspace(const qs_model *model)
{
    if (!qs_messages_fit(model, model->kept != NULL)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_trws_workspace, model);
    }
    qs_trws_state state = {.model = model};
    uint16_t *trial;
    return take_parts(&state, NULL, &trial);
}

static int64_t pass(const qs_trws_state *state, bool forward)
{
    return state->model->width > 0 ? qs_trws_grid_pass(state, forward)
                                   : qs_trws_graph_pass(state, forward);
}

/* Takes over the bound of a pass if it is higher. It is rounded up: energies are whole. */
static void raise_bound(const qs_trws_state *state, int64_t bound, qs_solution *s)
{
    unsigned shift = state->scale.shift;
    int64_t whole = bound / ((int64_t)1 << shift);
    whole += bound > whole * ((int64_t)1 << shift);
    whole += state->model->constant;
    s->lower_bound = whole > s->lower_bound ? whole : s->lower_bound;
}

static bool is_stopped(const qs_trws_state *state)
{
    return state->look && state->look->stopped;
}

void qs_trws_iterate(const qs_trws_state *state, uint64_t times)
{
    for (uint64_t i = 0; i < times && !is_stopped(state); i++) {
        pass(state, true);
        pass(state, false);
    }
}

void qs_trws_visit_only(qs_trws_state *state, const uint32_t *sites, uint32_t count)
{
    const qs_model *model = state->model;
    size_t labels = model->labels;
    state->visits = sites;
    state->visit_count = count;
    if (model->width == 0) {
        return; /* a graph's passes do not look at such edges */
    }
    for (uint32_t p = 0; p < model->sites; p++) {
        qs_number *right = state->messages + 2 * labels * p, *down = right + labels;
        memset(right, 0, model->right[p] == 0 ? sizeof *right * labels : 0);
        memset(down, 0, model->down[p] == 0 ? sizeof *down * labels : 0);
    }
}

void qs_trws_marginals(const qs_trws_state *state, qs_natural *marginals, int64_t *shares)
{
    if (state->model->width > 0) {
        qs_trws_grid_marginals(state, marginals, shares);
    } else {
        qs_trws_graph_marginals(state, marginals, shares);
    }
    pass(state, false);
}

/* Returns true if a cell has the label of all cells around it. Most have; then there is no other
 * label to take. */
static bool is_inside(const qs_model *model, uint32_t site, const uint16_t *labelling)
{
    uint32_t width = model->width;
    uint16_t label = labelling[site];
    return site >= width && site + width < model->sites && labelling[site - 1] == label &&
           labelling[site + 1] == label && labelling[site - width] == label &&
           labelling[site + width] == label;
}

/* Lets a site take the label of a neighbour where that is cheaper. Returns by how much the energy
 * falls. */
static int64_t take_from_neighbours(const qs_model *model, uint32_t site, uint16_t *labelling)
{
    if (qs_has_many_neighbours(model, site)) {
        uint16_t own = labelling[site];
        int64_t before = qs_label_cost(model, labelling, site, own);
        labelling[site] = qs_best_label(model, labelling, site);
        return before - qs_label_cost(model, labelling, site, labelling[site]);
    }
    qs_edge_seen edge;
    int64_t cost = INT64_MAX, gain = 0;
    for (uint32_t at = 0; qs_see_edge(model, site, at, &edge); at++) {
        uint16_t label = labelling[edge.site];
        if (edge.weight == 0 || label == labelling[site]) {
            continue;
        }
        cost = cost == INT64_MAX ? qs_label_cost(model, labelling, site, labelling[site]) : cost;
        int64_t other = qs_label_cost(model, labelling, site, label);
        if (other < cost) {
            gain += cost - other;
            cost = other;
            labelling[site] = label;
        }
    }
    return gain;
}

/* Goes over the sites until none changes, or the watch stops it. Returns by how much the energy
 * falls. */
static int64_t improve(const qs_trws_state *state, uint16_t *labelling)
{
    const qs_model *model = state->model;
    int64_t all = 0, gain = 1;
    while (gain > 0 && qs_look_up(state->look, model->sites)) {
        gain = 0;
        for (uint32_t p = 0; p < model->sites; p++) {
            bool inside = model->width > 0 && is_inside(model, p, labelling);
            if (!qs_look_up(state->look, inside ? 1 : qs_work_at(model, p))) {
                return all + gain;
            }
            if (!inside) {
                gain += take_from_neighbours(model, p, labelling);
            }
        }
        all += gain;
    }
    return all;
}

/* Makes a labelling from the messages. Keeps it if it is the best so far. */
static void try_labelling(const qs_trws_state *state, bool forward, uint16_t *trial,
                          uint16_t *labelling, qs_solution *s)
{
    if (state->model->width > 0) {
        qs_trws_grid_labels(state, forward, trial);
    } else {
        qs_trws_graph_labels(state, forward, trial);
    }
    if (is_stopped(state)) {
        return;
    }
    int64_t energy = qs_model_energy(state->model, trial);
    energy -= improve(state, trial);
    /* Beside large edges a label that is out can be cheap to the neighbours that improve it. */
    energy -= state->model->kept ? qs_take_kept_everywhere(state->model, trial) : 0;
    if (energy < s->energy) {
        s->energy = energy;
        memcpy(labelling, trial, sizeof *labelling * state->model->sites);
    }
}

/* Returns true if a labelling is to be made after this pass: after both passes of the first and the
 * last iteration; else after every LABELS_EVERY-th, in turn after the one pass and the other. */
static bool is_due(uint64_t iteration, bool last, bool forward)
{
    bool now = iteration % LABELS_EVERY == 0, odd = iteration / LABELS_EVERY % 2 != 0;
    return last || iteration == 1 || (now && odd == !forward);
}

/* Both passes of an iteration. Returns false if the watch has stopped it on the way. */
static bool iterate(const qs_trws_state *state, uint64_t number, bool last, uint16_t *trial,
                    uint16_t *labelling, qs_solution *s)
{
    for (int way = 0; way < 2; way++) {
        bool forward = way == 0;
        int64_t bound = pass(state, forward);
        if (is_stopped(state)) {
            return false;
        }
        raise_bound(state, bound, s);
        if (is_due(number, last, forward)) {
            try_labelling(state, !forward, trial, labelling, s);
        }
    }
    return !is_stopped(state);
}

static void solve(const qs_trws_state *state, const qs_solve_options *options, uint16_t *trial,
                  uint16_t *labelling, qs_solution *s)
{
    bool go = true;
    while (go && !s->converged) {
        qs_solution next = *s;
        next.iterations++;
        bool last = qs_limit_reached(options, &next, DEFAULT_ITERATIONS);
        bool whole = iterate(state, next.iterations, last, trial, labelling, s);
        s->iterations += whole;
        s->converged = s->energy == s->lower_bound;
        go = whole && qs_report_progress(options, s) && !last;
    }
}

qs_status qs_trws(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !solution) {
        return QS_E_ARGUMENT;
    }
    if (!qs_messages_fit(model, model->kept != NULL)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_trws, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    qs_trws_state state;
    qs_solution so_far;
    qs_reporter reporter = {options, &so_far};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    /* A witness needs the messages of whole iterations. */
    bool looks = !options || !options->witness;
    qs_status status = qs_trws_watched(model, options, looks ? &look : NULL, workspace,
                                       workspace_size, labelling, &so_far, &state);
    if (status == QS_OK) {
        *solution = so_far;
    }
    return status;
}

qs_status qs_trws_watched(const qs_model *model, const qs_solve_options *options, qs_look *look,
                          void *workspace, size_t workspace_size, uint16_t *labelling,
                          qs_solution *solution, qs_trws_state *state)
{
    if (!workspace || !labelling) {
        return QS_E_ARGUMENT;
    }
    uint16_t *trial;
    *state = (qs_trws_state){.model = model, .wide = qs_lanes_avx2(), .look = look};
    size_t size = take_parts(state, workspace, &trial);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    if (!qs_scale_choose(model, FINEST, &state->scale)) {
        return QS_E_OVERFLOW;
    }
    qs_model_winner(model, labelling);
    /* No cost is below 0. */
    *solution =
        (qs_solution){.energy = qs_model_energy(model, labelling), .lower_bound = model->constant};
    if (qs_clear(look, workspace, size)) {
        solve(state, options, trial, labelling, solution);
    }
    solution->energy -= qs_take_kept_everywhere(model, labelling);
    qs_witness_split(state, options, labelling);
    return QS_OK;
}
