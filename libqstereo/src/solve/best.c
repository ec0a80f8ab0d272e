#include "best.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"
#include "../model/metric.h"
#include "../model/neighbours.h"
#include "cut.h"
#include "fusion.h"
#include "pack.h"
#include "progress.h"
#include "solve_64.h"
#include "trws_split.h"

enum { ITERATIONS = 2000, FIRST_MOVES = 8 };

/* The most that packing may do before messages: labellings tried times sites and edges. */
static const uint64_t packing_work = UINT64_C(1) << 30;

/* It watches TRW-S: it takes over the bounds and the labellings, improves these by moves, and stops
 * TRW-S when the best labelling is proven. */
typedef struct supervisor {
    const qs_model *model;
    const qs_solve_options *options;
    const qs_guest *guest; /* NULL = nobody */
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
 * guest may raise costs until moves need more memory than there is: from then on there are none. */
static void improve(supervisor *s, uint16_t *labelling)
{
    qs_solve_options options = {.watch = watch_moves, .context = s};
    qs_solution moved;
    qs_status status =
        s->metric ? qs_expansion(s->model, &options, s->moves, s->moves_size, labelling, &moved)
                  : qs_fusion_moves(QS_FUSION_JUMPS, s->model, &options, s->moves, s->moves_size,
                                    labelling, &moved);
    if (status == QS_OK) {
        keep(s, labelling, moved.energy);
    }
}

/* The moves start from the labelling of TRW-S. The guest may have taken labels of it out since. */
static void start_moves(supervisor *s)
{
    memcpy(s->moved, s->found, sizeof *s->moved * s->model->sites);
    if (s->guest) {
        (void)qs_take_kept_everywhere(s->model, s->moved);
    }
}

static bool is_proven(const supervisor *s)
{
    return s->solution.energy <= s->solution.lower_bound;
}

static bool watch_messages(void *context, const qs_progress *progress)
{
    supervisor *s = context;
    s->solution.lower_bound = qs_max_i64(s->solution.lower_bound, progress->lower_bound);
    s->solution.iterations = progress->iteration;
    keep(s, s->found, progress->energy);
    /* Less and less often: TRW-S gets on slowly, and moves cost as much as many of its
     * iterations. */
    if (!is_proven(s) && progress->iteration >= s->next_moves &&
        progress->energy != s->moved_energy) {
        s->next_moves = 2 * progress->iteration;
        s->moved_energy = progress->energy;
        start_moves(s);
        improve(s, s->moved);
    }
    bool done = !s->stopped && s->guest &&
                !s->guest->between(s->guest->context, &s->state, &s->solution, false);
    (void)is_going(s);
    return !done && !is_proven(s) && !s->stopped;
}

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_parts(supervisor *s, void *workspace)
{
    qs_arena arena = {.base = workspace};
    s->moves_size = qs_expansion_workspace(s->model);
    size_t fusion = qs_fusion_moves_workspace(s->model);
    s->moves_size = fusion > s->moves_size ? fusion : s->moves_size;
    s->messages_size = qs_trws_workspace(s->model);
    s->found = qs_arena_take(&arena, s->model->sites, sizeof *s->found);
    s->moved = qs_arena_take(&arena, s->model->sites, sizeof *s->moved);
    s->moves = qs_arena_take(&arena, s->moves_size, 1);
    s->messages = qs_arena_take(&arena, s->messages_size, 1);
    return qs_arena_size(&arena);
}

/* Packing needs room of its own, and then for what it found beside the workspace of the others. */
static size_t packing_size(const qs_model *model, size_t others)
{
    qs_arena arena = {0};
    (void)qs_arena_take(&arena, model->sites, sizeof(uint16_t));
    (void)qs_arena_take(&arena, qs_max_u64(others, qs_pack_workspace(model)), 1);
    return qs_arena_size(&arena);
}

size_t qs_best_workspace(const qs_model *model)
{
    if (!qs_messages_fit(model, model->kept != NULL)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_best_workspace, model);
    }
    supervisor s = {.model = model};
    size_t others = take_parts(&s, NULL),
           cut = qs_cut_is_quick(model) ? qs_min_cut_workspace(model) : 0,
           packed = qs_can_pack(model) ? packing_size(model, others) : 0;
    others = packed > others ? packed : others;
    return cut > others && cut < SIZE_MAX ? cut : others;
}

/* A cut, in whose time nothing else would get lower. */
static qs_status cut_quickly(const qs_model *model, const qs_solve_options *options,
                             void *workspace, size_t workspace_size, uint16_t *labelling,
                             qs_solution *solution)
{
    qs_solve_options own = {0};
    if (options) { /* without their limit, which is one of messages */
        own = (qs_solve_options){.watch = options->watch, .context = options->context};
    }
    qs_model_winner(model, labelling);
    return qs_min_cut(model, &own, workspace, workspace_size, labelling, solution);
}

/* Packs within a limit of work. If that does not prove an optimum, the others go on, and the better
 * of the two labellings counts. */
static qs_status pack_first(const qs_model *model, const qs_solve_options *options, void *workspace,
                            size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    qs_arena arena = {.base = workspace};
    uint16_t *packed = qs_arena_take(&arena, model->sites, sizeof *packed);
    size_t size = workspace_size - (size_t)arena.used;
    void *rest = qs_arena_take(&arena, size, 1);
    qs_solve_options own = {.iterations = 1 + packing_work / (1 + model->sites + model->edges)};
    qs_solution first, second;
    if (options) {
        own.watch = options->watch;
        own.context = options->context;
    }
    qs_status status = qs_pack(model, &own, rest, size, labelling, &first);
    if (status == QS_OK && !first.converged) {
        memcpy(packed, labelling, sizeof *packed * model->sites);
        status = qs_best_with(model, options, NULL, rest, size, labelling, &second);
    }
    if (status != QS_OK) {
        return status;
    }
    if (first.converged) {
        *solution = first;
        return QS_OK;
    }
    if (first.energy < second.energy) {
        memcpy(labelling, packed, sizeof *packed * model->sites);
        second.energy = first.energy;
    }
    second.lower_bound = qs_max_i64(first.lower_bound, second.lower_bound);
    *solution = second;
    return QS_OK;
}

qs_status qs_best(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    if (!qs_messages_fit(model, model->kept != NULL)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_best, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    if (workspace_size < qs_best_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    if (qs_cut_is_quick(model) &&
        cut_quickly(model, options, workspace, workspace_size, labelling, solution) == QS_OK) {
        return QS_OK;
    }
    if (qs_can_pack(model)) {
        return pack_first(model, options, workspace, workspace_size, labelling, solution);
    }
    return qs_best_with(model, options, NULL, workspace, workspace_size, labelling, solution);
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
    /* A witness needs the messages of whole iterations. */
    qs_look *look = options && options->witness ? NULL : &s->look;
    qs_status status = qs_trws_watched(s->model, &own, look, s->messages, s->messages_size,
                                       s->found, &ended, &s->state);
    if (status == QS_OK) {
        qs_witness_split(&s->state, options, s->best);
    }
    if (status == QS_OK && s->stopped && s->guest) {
        s->guest->between(s->guest->context, &s->state, &s->solution, true);
    } else if (status == QS_OK && !s->guest) { /* stopped within an iteration */
        s->solution.lower_bound = qs_max_i64(s->solution.lower_bound, ended.lower_bound);
        keep(s, s->found, ended.energy);
    }
    return status;
}

qs_status qs_best_with(const qs_model *model, const qs_solve_options *options,
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
                    .next_moves = FIRST_MOVES};
    size_t size = take_parts(&s, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    qs_model_winner(model, labelling);
    s.solution.energy = qs_model_energy(model, labelling);
    s.solution.lower_bound = model->constant; /* no cost is below 0 */
    s.moved_energy = s.solution.energy;
    qs_status status = solve(&s);
    if (status == QS_OK) {
        s.solution.energy -= qs_take_kept_everywhere(model, labelling);
        s.solution.converged = is_proven(&s);
        *solution = s.solution;
    }
    return status;
}
