#include "../base/arena.h"
#include "../base/minmax.h"
#include "../model/neighbours.h"
#include "../solve/cut.h"
#include "../solve/messages.h"
#include "../solve/pack.h"
#include "../solve/progress.h"
#include "hand_over.h"

/* The most that packing may do before messages: labellings tried times sites and edges. */
static const uint64_t packing_work = UINT64_C(1) << 30;

/* The workspace, handed out. */
typedef struct room {
    uint8_t *kept; /* of the reduction */
    uint16_t *packed; /* the labelling of packing, where that goes first */
    void *rest;
    size_t rest_size;
} room;

static size_t take(const qs_model *model, void *workspace, room *r)
{
    qs_arena arena = {.base = workspace};
    bool packs = qs_can_pack(model);
    r->rest_size = qs_reduce_workspace(model);
    if (packs) {
        size_t packing = qs_pack_workspace(model);
        r->rest_size = packing > r->rest_size ? packing : r->rest_size;
    }
    r->kept = qs_arena_take(&arena, model->sites, model->labels);
    r->packed = packs ? qs_arena_take(&arena, model->sites, sizeof *r->packed) : NULL;
    r->rest = qs_arena_take(&arena, r->rest_size, 1);
    return qs_arena_size(&arena);
}

size_t qs_best_workspace(const qs_model *model)
{
    if (!qs_messages_fit(model, true)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_best_workspace, model);
    }
    room r;
    size_t all = take(model, NULL, &r),
           cut = qs_cut_is_quick(model) ? qs_min_cut_workspace(model) : 0;
    return cut > all && cut < SIZE_MAX ? cut : all;
}

/* The limits of messages are none of cuts and of packing. */
static qs_solve_options with_watch_of(const qs_solve_options *options)
{
    return options ? (qs_solve_options){.watch = options->watch,
                                        .context = options->context,
                                        .witness = options->witness}
                   : (qs_solve_options){0};
}

/* A cut, in whose time nothing else would get lower. A cut of two labels that is stopped returns
 * what it began with, so that is what a sweep of icm finds, which is too short for the watch. */
static qs_status cut_quickly(const qs_model *model, const qs_solve_options *options,
                             void *workspace, size_t workspace_size, uint16_t *labelling,
                             qs_solution *solution)
{
    qs_solve_options own = with_watch_of(options);
    const qs_solve_options sweep = {.iterations = 1};
    qs_model_winner(model, labelling);
    qs_status status =
        model->labels == 2 ? qs_icm(model, &sweep, NULL, 0, labelling, solution) : QS_OK;
    return status != QS_OK
               ? status
               : qs_min_cut(model, &own, workspace, workspace_size, labelling, solution);
}

/* The watch of a reduction, which tells that of a solver. */
static bool watch(void *context, const qs_reduction *so_far)
{
    const qs_solve_options *options = context;
    qs_progress now = {so_far->upper_bound, so_far->lower_bound, so_far->iterations};
    return options->watch(options->context, &now);
}

static qs_status reduce(const qs_model *model, const qs_solve_options *options, const room *r,
                        uint16_t *labelling, qs_solution *solution)
{
    qs_solve_options asked = options ? *options : (qs_solve_options){0};
    const qs_reduce_options own = {.iterations = asked.iterations,
                                   .watch = asked.watch ? watch : NULL,
                                   .context = &asked,
                                   .start = asked.start,
                                   .witness = asked.witness};
    const qs_reduce_aim aim = {.answer = true};
    qs_reduction found;
    qs_status status = qs_reduce_as(model, &own, &aim, r->rest, r->rest_size, r->kept, labelling,
                                    &found, &solution->converged);
    if (status == QS_OK) {
        solution->energy = found.upper_bound;
        solution->lower_bound = found.lower_bound;
        solution->iterations = found.iterations;
    }
    return status;
}

/* Packs within a limit of work. If that does not prove an optimum, or a witness has to be told what
 * proves it, the reduction goes on from there. */
static qs_status pack_first(const qs_model *model, const qs_solve_options *options, const room *r,
                            uint16_t *labelling, qs_solution *solution)
{
    qs_solve_options own = with_watch_of(options);
    own.iterations = 1 + packing_work / (1 + model->sites + model->edges);
    qs_solution first;
    qs_status status = qs_pack(model, &own, r->rest, r->rest_size, labelling, &first);
    if (status != QS_OK || (first.converged && !own.witness)) {
        *solution = first;
        return status;
    }
    qs_solve_options asked = options ? *options : (qs_solve_options){0};
    memcpy(r->packed, labelling, sizeof *labelling * model->sites);
    if (!asked.start || qs_model_energy(model, asked.start) > first.energy) {
        asked.start = r->packed;
    }
    status = reduce(model, &asked, r, labelling, solution);
    solution->lower_bound = qs_max_i64(first.lower_bound, solution->lower_bound);
    solution->converged = solution->converged || first.converged;
    return status;
}

static qs_status solve(const qs_model *model, const qs_solve_options *options, void *workspace,
                       size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    room r;
    (void)take(model, workspace, &r);
    if (qs_cut_is_quick(model) &&
        cut_quickly(model, options, workspace, workspace_size, labelling, solution) == QS_OK) {
        return QS_OK;
    }
    return r.packed ? pack_first(model, options, &r, labelling, solution)
                    : reduce(model, options, &r, labelling, solution);
}

/* A solver that was stopped early, or that knows nothing of the start, may be above it. */
static void take_start(const qs_model *model, const uint16_t *start, uint16_t *labelling,
                       qs_solution *solution)
{
    int64_t energy = qs_model_energy(model, start);
    if (energy < solution->energy) {
        memcpy(labelling, start, sizeof *start * model->sites);
        solution->energy = energy - qs_take_kept_everywhere(model, labelling);
    }
}

qs_status qs_best(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    const uint16_t *start = options ? options->start : NULL;
    if (!model || !workspace || !labelling || !solution ||
        (start && !qs_labels_in_range(model, start))) {
        return QS_E_ARGUMENT;
    }
    if (!qs_messages_fit(model, true)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_best, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    if (workspace_size < qs_best_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    qs_solution found;
    qs_status status = solve(model, options, workspace, workspace_size, labelling, &found);
    if (status == QS_OK) {
        *solution = found;
    }
    if (status == QS_OK && start) {
        take_start(model, start, labelling, solution);
    }
    return status;
}
