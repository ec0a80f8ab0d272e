#include "messages_and_moves.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"
#include "../model/metric.h"
#include "../model/neighbours.h"
#include "fusion.h"
#include "progress.h"

enum {
    ITERATIONS = 2000,
    FIRST_MOVES = 8,
    MOVES_SLOWER = 16 /* a move takes so many times as long as an iteration for one label */
};

/* It watches TRW-S: it takes over the bounds and the labellings, improves these by moves, and stops
 * TRW-S when the best labelling is proven. */
typedef struct supervisor {
    const qs_model *model;
    const qs_solve_options *options;
    const qs_guest *guest;
    qs_trws_state state;
    void *moves, *messages; /* workspaces */
    size_t moves_size, messages_size;
    uint16_t *best; /* the caller's labelling */
    uint16_t *found; /* the best of TRW-S */
    uint16_t *moved; /* that one, improved by moves */
    int64_t moved_energy; /* of the labelling that moves began with last */
    uint64_t next_moves; /* the iteration that they are due at */
    bool metric; /* the pairwise cost is one */
    bool stopped; /* by the caller's watch */
    qs_look look; /* of messages at that watch */
    qs_solution solution;
} supervisor;

/* Keeps a labelling if it is the best so far. */
static void keep(supervisor *s, const uint16_t *labelling, int64_t energy)
{
    if (energy < s->solution.energy) {
        memcpy(s->best, labelling, sizeof *labelling * s->model->sites);
        s->solution.energy = energy;
    }
}

/* Within moves and within iterations the caller's watch is only asked whether to stop. */
static bool is_going(void *context)
{
    supervisor *s = context;
    s->stopped = s->stopped || !qs_report_progress(s->options, &s->solution);
    return !s->stopped;
}

static bool watch_moves(void *context, const qs_progress *progress)
{
    (void)progress;
    return is_going(context);
}

/* Improves a labelling by expansion, or, where the pairwise cost is no metric, by fusion moves. A
 * guest may raise costs until moves need more memory than there is: from then on there are none.
 * Returns how many iterations take as long. */
static uint64_t improve(supervisor *s, uint16_t *labelling)
{
    const qs_model *model = s->model;
    qs_solve_options options = {.watch = watch_moves, .context = s};
    qs_solution moved;
    qs_fusion_kind kind = s->metric ? QS_FUSION_EXPANSION : QS_FUSION_JUMPS;
    qs_status status =
        s->metric
            ? qs_expansion(model, &options, s->moves, s->moves_size, labelling, &moved)
            : qs_fusion_moves(kind, model, &options, s->moves, s->moves_size, labelling, &moved);
    if (status != QS_OK) {
        return 0;
    }
    keep(s, labelling, moved.energy);
    return moved.iterations * qs_fusion_count(model, kind) * MOVES_SLOWER / model->labels;
}

/* The moves start from the labelling of TRW-S. The guest may have taken labels of it out since. */
static void start_moves(supervisor *s)
{
    memcpy(s->moved, s->found, sizeof *s->moved * s->model->sites);
    (void)qs_take_kept_everywhere(s->model, s->moved);
}

static bool watch_messages(void *context, const qs_progress *progress)
{
    supervisor *s = context;
    s->solution.lower_bound = qs_max_i64(s->solution.lower_bound, progress->lower_bound);
    s->solution.iterations = progress->iteration;
    keep(s, s->found, progress->energy);
    bool near = qs_is_proven(&s->solution);
    /* Less and less often, for TRW-S gets on slowly; and not before it has had as much time as the
     * moves before. */
    if (!near && progress->iteration >= s->next_moves && progress->energy != s->moved_energy) {
        s->moved_energy = progress->energy;
        start_moves(s);
        uint64_t pause = improve(s, s->moved);
        s->next_moves = progress->iteration + qs_max_u64(pause, progress->iteration);
        near = qs_is_proven(&s->solution);
    }
    bool done =
        !s->stopped && !s->guest->between(s->guest->context, &s->state, &s->solution, false);
    (void)is_going(s);
    return !done && !near && !qs_is_proven(&s->solution) && !s->stopped;
}

static size_t moves_size(const qs_model *model)
{
    size_t expansion = qs_expansion_workspace(model), fusion = qs_fusion_moves_workspace(model);
    return fusion > expansion ? fusion : expansion;
}

/* Hands out the workspace, or counts it; moves_size is set. Returns its size. */
static size_t take_parts(supervisor *s, void *workspace)
{
    qs_arena arena = {.base = workspace};
    s->messages_size = qs_trws_workspace(s->model);
    s->found = qs_arena_take(&arena, s->model->sites, sizeof *s->found);
    s->moved = qs_arena_take(&arena, s->model->sites, sizeof *s->moved);
    s->moves = qs_arena_take(&arena, s->moves_size, 1);
    s->messages = qs_arena_take(&arena, s->messages_size, 1);
    return qs_arena_size(&arena);
}

size_t qs_messages_and_moves_workspace(const qs_model *model)
{
    supervisor s = {.model = model, .moves_size = moves_size(model)};
    return take_parts(&s, NULL);
}

static qs_status solve(supervisor *s)
{
    const qs_solve_options *options = s->options;
    uint64_t iterations = options ? options->iterations : 0;
    qs_solve_options own = {.iterations = iterations > 0 ? iterations : ITERATIONS,
                            .watch = watch_messages,
                            .context = s};
    qs_solution ended;
    s->look = (qs_look){.going = is_going, .context = s};
    qs_status status = qs_trws_watched(s->model, &own, &s->look, s->messages, s->messages_size,
                                       s->found, &ended, &s->state);
    if (status == QS_OK && s->stopped) { /* perhaps within an iteration */
        s->solution.lower_bound = qs_max_i64(s->solution.lower_bound, ended.lower_bound);
        keep(s, s->found, qs_model_energy(s->model, s->found)); /* of kept labels by now */
        s->guest->between(s->guest->context, &s->state, &s->solution, true);
    }
    return status;
}

qs_status qs_messages_and_moves(const qs_model *model, const qs_solve_options *options,
                                const qs_guest *guest, void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    supervisor s = {.model = model,
                    .options = options,
                    .guest = guest,
                    .best = labelling,
                    .metric = qs_is_metric(model),
                    .moves_size = moves_size(model),
                    .next_moves = FIRST_MOVES,
                    .moved_energy = INT64_MAX};
    size_t size = take_parts(&s, NULL), missing = size > workspace_size ? size - workspace_size : 0;
    if (size == SIZE_MAX || missing > s.moves_size) {
        return QS_E_WORKSPACE;
    }
    s.moves_size -= missing; /* the guest has raised costs before: see `improve` */
    (void)take_parts(&s, workspace);
    qs_model_winner(model, labelling);
    s.solution.energy = qs_model_energy(model, labelling);
    s.solution.lower_bound = model->constant; /* no cost is below 0 */
    qs_status status = solve(&s);
    if (status == QS_OK) {
        s.solution.energy -= qs_take_kept_everywhere(model, labelling);
        s.solution.converged = qs_is_proven(&s.solution);
        *solution = s.solution;
    }
    return status;
}
