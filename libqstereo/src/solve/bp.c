#include "bp.h"

#include <string.h>

#include "label_from_messages.h"
#include "../base/simd.h"
#include "../model/neighbours.h"
#include "progress.h"

enum { DEFAULT_ITERATIONS = 50, FINEST = 12 };

size_t qs_bp_messages(const qs_model *model)
{
    return (model->width > 0 ? QS_FROM_ALL * (size_t)model->sites : 2 * (size_t)model->edges) *
           model->labels;
}

size_t qs_bp_scratch(const qs_model *model)
{
    enum { RUN = 8 };
    return 4 * ((size_t)model->labels + RUN) + qs_message_scratch(model);
}

size_t qs_bp_workspace(const qs_model *model)
{
    uint64_t all = (uint64_t)QS_FROM_ALL * model->sites * model->labels,
             edges = (uint64_t)2 * model->edges * model->labels;
    uint64_t count =
        (model->width > 0 ? all : edges) + qs_bp_scratch(model) + ((uint64_t)model->sites + 1) / 2;
    return count > SIZE_MAX / sizeof(int32_t) ? SIZE_MAX : (size_t)count * sizeof(int32_t);
}

void qs_bp_send(const qs_bp_state *state, int32_t weight, bool upward, int32_t *costs,
                int32_t *message, int32_t *scratch)
{
    uint32_t labels = state->model->labels;
    qs_message_send(state->model, weight, upward, costs, scratch, scratch + labels);
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = scratch[d] +
                     (int32_t)((int64_t)(message[d] - scratch[d]) * QS_KEEP / (1 << QS_KEEP_OF));
    }
}

static void sweep(const qs_bp_state *state, bool wide)
{
    const qs_model *model = state->model;
    (void)wide;
    if (model->width == 0) {
        qs_bp_graph_sweep(state);
        return;
    }
#if QS_HAVE_AVX2
    if (wide && model->labels >= QS_LANES && model->pairwise.smoothness == QS_POTTS) {
        qs_bp_wide_sweep(state);
        return;
    }
#endif
    qs_bp_grid_sweep(state);
}

static void decode(const qs_bp_state *state, bool wide, uint16_t *labelling)
{
    size_t labels = state->model->labels;
    if (state->model->width == 0) {
        qs_bp_graph_labels(state, labelling);
        return;
    }
    qs_decoder decoder = {state->model,
                          state->scale,
                          wide,
                          true,
                          state->messages + QS_FROM_RIGHT * labels,
                          state->messages + QS_FROM_BELOW * labels,
                          QS_FROM_ALL * labels,
                          state->scratch};
    qs_decode_grid(&decoder, labelling);
}

qs_status qs_bp(const qs_model *model, const qs_solve_options *options, void *workspace,
                size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    qs_bp_state state = {.model = model};
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_bp_workspace(model) || qs_bp_workspace(model) == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    if (!qs_scale_choose(model, FINEST, &state.scale)) {
        return QS_E_OVERFLOW;
    }
    memset(workspace, 0, qs_bp_workspace(model));
    state.messages = workspace;
    state.scratch = state.messages + qs_bp_messages(model);
    uint16_t *trial = (uint16_t *)(state.scratch + qs_bp_scratch(model));
    qs_solution s = {.lower_bound = QS_NO_BOUND};
    bool wide = qs_lanes_avx2();
    for (bool go = true; go;) {
        sweep(&state, wide);
        decode(&state, wide, trial);
        int64_t energy = qs_model_energy(model, trial);
        if (s.iterations == 0 || energy < s.energy) {
            s.energy = energy;
            memcpy(labelling, trial, sizeof *labelling * model->sites);
        }
        s.iterations++;
        go = qs_told(options, &s) && !qs_limit_reached(options, &s, DEFAULT_ITERATIONS);
    }
    s.energy -= qs_local_keep(model, labelling);
    *solution = s;
    return QS_OK;
}
