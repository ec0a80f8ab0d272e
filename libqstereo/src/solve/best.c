#include "best.h"

#include <string.h>

#include "../base/bytes.h"
#include "../model/neighbours.h"
#include "cut.h"
#include "progress.h"

enum { ITERATIONS = 2000, FIRST_MOVES = 8 };

/* What TRW-S is watched by: it takes over its bounds and labellings, improves these by moves, and
 * ends it when the best labelling is proven. */
typedef struct supervisor {
    const qs_model *model;
    const qs_solve_options *options;
    const qs_guest *guest; /* NULL = nobody */
    qs_trws_state state;
    void *workspace; /* of the moves */
    size_t workspace_size;
    uint16_t *best; /* the caller's labelling */
    const uint16_t *found; /* TRW-S's best */
    uint16_t *moved;
    int64_t moved_energy; /* of the labelling last improved by moves */
    uint64_t next_moves; /* the iteration that they are due at */
    bool no_metric; /* expansion has refused the pairwise cost */
    qs_solution solution;
    bool stopped; /* by the caller's watch */
} supervisor;

static void keep(supervisor *s, const uint16_t *labelling, int64_t energy)
{
    if (energy < s->solution.energy) {
        memcpy(s->best, labelling, sizeof *labelling * s->model->sites);
        s->solution.energy = energy;
    }
}

/* Passes on what a move's own watch is told: time goes by in moves, too. */
static bool watch_moves(void *context, const qs_progress *progress)
{
    supervisor *s = context;
    (void)progress;
    s->stopped = s->stopped || !qs_told(s->options, &s->solution);
    return !s->stopped;
}

/* Expansion where the pairwise cost is a metric, else the descent that takes any. */
static qs_status improve(supervisor *s, uint16_t *labelling)
{
    qs_solve_options options = {.watch = watch_moves, .context = s};
    qs_solution moved;
    qs_status status = QS_E_ENCODING;
    if (!s->no_metric) {
        status =
            qs_expansion(s->model, &options, s->workspace, s->workspace_size, labelling, &moved);
    }
    if (status == QS_E_ENCODING || status == QS_E_OVERFLOW) {
        s->no_metric = true;
        status = qs_icm(s->model, &options, NULL, 0, labelling, &moved);
    }
    if (status == QS_OK) {
        keep(s, labelling, moved.energy);
    }
    return status;
}

/* A start for the moves: TRW-S's labelling, which may have labels that the guest has taken out
 * since. */
static void start_moves(supervisor *s)
{
    memcpy(s->moved, s->found, sizeof *s->moved * s->model->sites);
    for (uint32_t p = 0; s->guest && p < s->model->sites; p++) {
        qs_local_mend(s->model, s->moved, p);
    }
}

static bool watch_messages(void *context, const qs_progress *progress)
{
    supervisor *s = context;
    s->solution.lower_bound = progress->lower_bound > s->solution.lower_bound
                                  ? progress->lower_bound
                                  : s->solution.lower_bound;
    s->solution.iterations = progress->iteration;
    keep(s, s->found, progress->energy);
    bool proven = s->solution.energy == s->solution.lower_bound;
    /* Rarer and rarer: TRW-S moves on slowly, and a cut costs as much as many of its iterations. */
    if (!proven && progress->iteration >= s->next_moves && progress->energy != s->moved_energy) {
        s->next_moves = 2 * progress->iteration;
        s->moved_energy = progress->energy;
        start_moves(s);
        proven = improve(s, s->moved) != QS_OK || s->solution.energy == s->solution.lower_bound;
    }
    bool done = !s->stopped && s->guest &&
                !s->guest->between(s->guest->context, &s->state, &s->solution, false);
    s->stopped = s->stopped || !qs_told(s->options, &s->solution);
    if (s->stopped && s->guest) {
        s->guest->between(s->guest->context, &s->state, &s->solution, true);
    }
    return !done && !proven && s->solution.energy > s->solution.lower_bound && !s->stopped;
}

/* Parts of the workspace, each on a multiple of 16: two labellings, then the workspaces of moves
 * and of messages. */
typedef struct layout {
    uint64_t moved, moves, messages, end;
} layout;

static layout lay_out(const qs_model *model)
{
    layout l = {0};
    uint64_t moves = qs_expansion_workspace(model), messages = qs_trws_workspace(model);
    l.moved = qs_rounded(sizeof(uint16_t) * (uint64_t)model->sites);
    l.moves = 2 * l.moved;
    l.messages = l.moves + (moves < SIZE_MAX ? qs_rounded(moves) : 0);
    l.end = moves < SIZE_MAX && messages < SIZE_MAX ? l.messages + messages : SIZE_MAX;
    return l;
}

size_t qs_best_workspace(const qs_model *model)
{
    uint64_t cut = qs_cut_is_quick(model) ? qs_min_cut_workspace(model) : 0;
    uint64_t others = lay_out(model).end;
    return qs_size(cut > others && cut < SIZE_MAX ? cut : others);
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

qs_status qs_best(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_best_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    if (qs_cut_is_quick(model) &&
        cut_quickly(model, options, workspace, workspace_size, labelling, solution) == QS_OK) {
        return QS_OK;
    }
    return qs_best_with(model, options, NULL, workspace, workspace_size, labelling, solution);
}

qs_status qs_best_with(const qs_model *model, const qs_solve_options *options,
                       const qs_guest *guest, void *workspace, size_t workspace_size,
                       uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    layout l = lay_out(model);
    if (workspace_size < l.end || l.end >= SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    char *base = workspace;
    uint16_t *found = workspace;
    supervisor s = {.model = model,
                    .options = options,
                    .guest = guest,
                    .best = labelling,
                    .found = found,
                    .next_moves = FIRST_MOVES};
    s.moved = (uint16_t *)(void *)(base + l.moved);
    s.workspace = base + l.moves;
    s.workspace_size = (size_t)(l.messages - l.moves);
    qs_model_winner(model, labelling);
    s.solution =
        (qs_solution){.energy = qs_model_energy(model, labelling), .lower_bound = QS_NO_BOUND};
    s.moved_energy = s.solution.energy;
    qs_solve_options own = {.iterations = options && options->iterations > 0 ? options->iterations
                                                                             : ITERATIONS,
                            .watch = watch_messages,
                            .context = &s};
    qs_solution ended;
    qs_status status = qs_trws_watched(model, &own, base + l.messages, (size_t)(l.end - l.messages),
                                       found, &ended, &s.state);
    if (status == QS_E_OVERFLOW) { /* costs too large for messages: moves alone, without a bound */
        memcpy(s.moved, labelling, sizeof *labelling * model->sites);
        status = improve(&s, s.moved);
    }
    if (status == QS_OK) {
        s.solution.energy -= qs_local_keep(model, labelling);
        s.solution.converged = s.solution.energy == s.solution.lower_bound;
        *solution = s.solution;
    }
    return status;
}
