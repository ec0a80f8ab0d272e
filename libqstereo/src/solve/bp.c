#include "bp.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/simd.h"
#include "../model/neighbours.h"
#include "label_from_messages.h"
#include "progress.h"
#include "solve_64.h"

enum { DEFAULT_ITERATIONS = 50, FINEST = 12 };

static uint64_t message_count(const qs_model *model)
{
    return model->width > 0 ? QS_FROM_ALL * (uint64_t)model->sites : 2 * (uint64_t)model->edges;
}

/* Four rows of costs, rounded up to whole runs of lanes, and what a message needs. */
static uint64_t scratch_count(const qs_model *model)
{
    enum { RUN = 8 };
    return 4 * ((uint64_t)model->labels + RUN) + qs_message_scratch(model);
}

/* Hands out the workspace, or counts it. Returns its size.
 *
 * trial  out: a labelling */
static size_t take_parts(qs_bp_state *state, void *workspace, uint16_t **trial)
{
    const qs_model *model = state->model;
    qs_arena arena = {.base = workspace};
    state->messages = qs_arena_take(&arena, message_count(model),
                                    model->labels * (uint64_t)sizeof *state->messages);
    state->scratch = qs_arena_take(&arena, scratch_count(model), sizeof *state->scratch);
    *trial = qs_arena_take(&arena, model->sites, sizeof **trial);
    return qs_arena_size(&arena);
}

size_t qs_bp_workspace(const qs_model *model)
{
    if (!qs_messages_fit(model, model->kept != NULL)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_bp_workspace, model);
    }
    qs_bp_state state = {.model = model};
    uint16_t *trial;
    return take_parts(&state, NULL, &trial);
}

static void sweep(const qs_bp_state *state, bool wide)
{
    const qs_model *model = state->model;
    (void)wide;
    if (model->width == 0) {
        qs_bp_graph_sweep(state);
        return;
    }
#if QS_HAVE_AVX2 && QS_BITS == 32
    if (wide && model->labels >= QS_LANES && model->pairwise.smoothness == QS_POTTS) {
        qs_bp_wide_sweep(state);
        return;
    }
#endif
    qs_bp_grid_sweep(state);
}

static void make_labelling(const qs_bp_state *state, bool wide, uint16_t *labelling)
{
    size_t labels = state->model->labels;
    if (state->model->width == 0) {
        qs_bp_graph_labels(state, labelling);
        return;
    }
    qs_message_reader reader = {.model = state->model,
                                .scale = state->scale,
                                .wide = wide,
                                .forward = true,
                                .row = state->messages + QS_FROM_RIGHT * labels,
                                .column = state->messages + QS_FROM_BELOW * labels,
                                .stride = QS_FROM_ALL * labels,
                                .scratch = state->scratch,
                                .look = state->look};
    qs_label_grid(&reader, labelling);
}

/* One iteration, and its labelling if that is the best so far. Returns false if the watch has
 * stopped it. */
static bool iterate(const qs_bp_state *state, bool wide, uint16_t *trial, uint16_t *labelling,
                    qs_solution *s)
{
    sweep(state, wide);
    if (!state->look->stopped) {
        make_labelling(state, wide, trial);
    }
    if (state->look->stopped) {
        return false;
    }
    int64_t energy = qs_model_energy(state->model, trial);
    if (s->iterations == 0 || energy < s->energy) {
        s->energy = energy;
        memcpy(labelling, trial, sizeof *labelling * state->model->sites);
    }
    return true;
}

qs_status qs_bp(const qs_model *model, const qs_solve_options *options, void *workspace,
                size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    qs_bp_state state = {.model = model};
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    if (!qs_scale_choose(model, FINEST, &state.scale)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_bp, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    uint16_t *trial;
    size_t size = take_parts(&state, workspace, &trial);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    qs_model_winner(model, labelling);
    qs_solution s = {.energy = qs_model_energy(model, labelling), .lower_bound = QS_NO_BOUND};
    qs_reporter reporter = {options, &s};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    state.look = &look;
    bool wide = qs_lanes_avx2();
    bool go = qs_clear(&look, workspace, size);
    while (go && iterate(&state, wide, trial, labelling, &s)) {
        s.iterations++;
        go = qs_report_progress(options, &s) && !qs_limit_reached(options, &s, DEFAULT_ITERATIONS);
    }
    s.energy -= qs_take_kept_everywhere(model, labelling);
    *solution = s;
    return QS_OK;
}
