#include "trws.h"

#include <string.h>

#include "../base/simd.h"
#include "../model/neighbours.h"
#include "progress.h"

enum { DEFAULT_ITERATIONS = 500, FINEST = 14, DECODE_EVERY = 8 };

/* Parts of the workspace: messages behind their padding, scratch, and a labelling. */
static uint64_t numbers(const qs_model *model)
{
    return qs_trws_padding(model) + qs_trws_messages(model) + qs_trws_scratch(model) +
           (model->sites + (uint64_t)1) / 2;
}

size_t qs_trws_workspace(const qs_model *model)
{
    uint64_t count = numbers(model);
    return count > SIZE_MAX / sizeof(int32_t) ? SIZE_MAX : (size_t)count * sizeof(int32_t);
}

static int64_t pass(const qs_trws_state *state, bool forward)
{
    return state->model->width > 0 ? qs_trws_grid_pass(state, forward)
                                   : qs_trws_graph_pass(state, forward);
}

/* A pass may only raise the bound, which is rounded up: energies are whole. */
static void raise_bound(const qs_trws_state *state, int64_t bound, qs_solution *s)
{
    unsigned shift = state->scale.shift;
    int64_t whole = bound / ((int64_t)1 << shift);
    whole += bound > whole * ((int64_t)1 << shift);
    whole += state->model->constant;
    s->lower_bound = whole > s->lower_bound ? whole : s->lower_bound;
}

void qs_trws_iterate(const qs_trws_state *state, uint64_t times)
{
    for (uint64_t i = 0; i < times; i++) {
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
    for (uint32_t p = 0; model->width > 0 && p < model->sites;
         p++) { /* a graph's passes do not look at such edges */
        int32_t *right = state->messages + 2 * labels * p, *down = right + labels;
        memset(right, 0, model->right[p] == 0 ? sizeof *right * labels : 0);
        memset(down, 0, model->down[p] == 0 ? sizeof *down * labels : 0);
    }
}

void qs_trws_excess(const qs_trws_state *state, uint32_t *excess, int64_t *shares)
{
    if (state->model->width > 0) {
        qs_trws_grid_excess(state, excess, shares);
    } else {
        qs_trws_graph_excess(state, excess, shares);
    }
    pass(state, false);
}

/* Whether a cell has the label of all cells beside it: most have, and nothing to take. */
static bool is_inside(const qs_model *model, uint32_t site, const uint16_t *labelling)
{
    uint32_t width = model->width;
    uint16_t label = labelling[site];
    return site >= width && site + width < model->sites && labelling[site - 1] == label &&
           labelling[site + 1] == label && labelling[site - width] == label &&
           labelling[site + width] == label;
}

/* Lets a site take a neighbour's label where that is cheaper; by how much it lowers the energy. */
static int64_t take_from_neighbours(const qs_model *model, uint32_t site, uint16_t *labelling)
{
    if (qs_local_many(model, site)) {
        uint16_t own = labelling[site];
        int64_t before = qs_local_cost(model, labelling, site, own);
        labelling[site] = qs_local_best(model, labelling, site);
        return before - qs_local_cost(model, labelling, site, labelling[site]);
    }
    qs_beside beside;
    int64_t cost = INT64_MAX, gain = 0;
    for (uint32_t at = 0; qs_local_neighbour(model, site, at, &beside); at++) {
        uint16_t label = labelling[beside.site];
        if (beside.weight == 0 || label == labelling[site]) {
            continue;
        }
        cost = cost == INT64_MAX ? qs_local_cost(model, labelling, site, labelling[site]) : cost;
        int64_t other = qs_local_cost(model, labelling, site, label);
        if (other < cost) {
            gain += cost - other;
            cost = other;
            labelling[site] = label;
        }
    }
    return gain;
}

static int64_t improve(const qs_model *model, uint16_t *labelling)
{
    int64_t all = 0, gain = 1;
    while (gain > 0) {
        gain = 0;
        for (uint32_t p = 0; p < model->sites; p++) {
            gain += model->width > 0 && is_inside(model, p, labelling)
                        ? 0
                        : take_from_neighbours(model, p, labelling);
        }
        all += gain;
    }
    return all;
}

static void decode(const qs_trws_state *state, bool forward, uint16_t *trial, uint16_t *labelling,
                   qs_solution *s)
{
    if (state->model->width > 0) {
        qs_trws_grid_labels(state, forward, trial);
    } else {
        qs_trws_graph_labels(state, forward, trial);
    }
    int64_t energy = qs_model_energy(state->model, trial);
    energy -= improve(state->model, trial);
    if (energy < s->energy) {
        s->energy = energy;
        memcpy(labelling, trial, sizeof *labelling * state->model->sites);
    }
}

qs_status qs_trws(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    qs_trws_state state;
    return qs_trws_watched(model, options, workspace, workspace_size, labelling, solution, &state);
}

qs_status qs_trws_watched(const qs_model *model, const qs_solve_options *options, void *workspace,
                          size_t workspace_size, uint16_t *labelling, qs_solution *solution,
                          qs_trws_state *state)
{
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_trws_workspace(model) || qs_trws_workspace(model) == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    *state = (qs_trws_state){.model = model, .wide = qs_lanes_avx2()};
    if (!qs_scale_choose(model, FINEST, &state->scale)) {
        return QS_E_OVERFLOW;
    }
    memset(workspace, 0, qs_trws_workspace(model));
    state->messages = (int32_t *)workspace + qs_trws_padding(model);
    state->scratch = state->messages + qs_trws_messages(model);
    uint16_t *trial = (uint16_t *)(state->scratch + qs_trws_scratch(model));
    qs_solution s = {.energy = INT64_MAX, .lower_bound = QS_NO_BOUND};
    bool go = true;
    while (go && !s.converged) {
        s.iterations++;
        bool last = qs_limit_reached(options, &s, DEFAULT_ITERATIONS);
        bool now = s.iterations % DECODE_EVERY == 0;
        bool both = last || s.iterations == 1, odd = s.iterations / DECODE_EVERY % 2 != 0;
        for (int way = 0; way < 2; way++) {
            raise_bound(state, pass(state, way == 0), &s);
            if (both || (now && odd == (way != 0))) {
                decode(state, way != 0, trial, labelling, &s);
            }
        }
        s.converged = s.energy == s.lower_bound;
        go = qs_told(options, &s) && !last;
    }
    s.energy -= qs_local_keep(model, labelling);
    *solution = s;
    return QS_OK;
}
