#include "../../include/qstereo/reduce.h"

#include "../solve/best.h"
#include "../base/bytes.h"
#include "label_sets.h"

enum {
    ITERATIONS = 2000,
    FIRST = 8, /* the first iteration at which to look for the excess */
    WIDEST = 4, /* times the largest cost: no excess is above that, for a label costs no more than
                   that on its chains beside the others */
    BETWEEN = 8, /* after the proof: so many iterations between two looks, and one for each so many
                    done before */
    FEW = 2 /* of so many parts of the sites one or less is few: then passes go by the list of them,
               else two rows at once */
};

/* The guest of qs_best_with. */
typedef struct reducer {
    qs_elimination sets;
    const qs_reduce_options *options;
    uint64_t iterations, target; /* of the options */
    uint32_t *excess;
    int64_t *shares;
    uint64_t next; /* without target: the iteration at which to look for the excess */
    int64_t looked; /* the gap when that was done last, */
    uint64_t looked_at; /* and the iteration */
    bool stopped; /* by the watch */
    qs_reduction so_far;
} reducer;

static void count(reducer *r)
{
    r->so_far.open = r->sets.open;
    r->so_far.variables = r->sets.variables;
}

static bool tell(void *context, const qs_progress *progress)
{
    reducer *r = context;
    r->so_far.upper_bound = progress->energy;
    r->so_far.lower_bound = progress->lower_bound;
    r->so_far.iterations = progress->iteration;
    r->stopped = r->stopped || (r->options && r->options->watch &&
                                !r->options->watch(r->options->context, &r->so_far));
    return !r->stopped;
}

/* Whether it is time for the excess: at the end in any case, and where it can be above the gap.
 * With a target as often as the gap has narrowed. */
static bool is_due(reducer *r, const qs_trws_state *state, const qs_solution *so_far, bool stopped)
{
    int64_t gap = so_far->energy - so_far->lower_bound;
    if (stopped) {
        return r->looked_at != so_far->iterations;
    }
    if (gap == 0 || so_far->iterations >= r->iterations) {
        return true;
    }
    if (gap / WIDEST > state->scale.most) {
        return false;
    }
    if (r->target > 0) {
        return gap < r->looked;
    }
    if (so_far->iterations < r->next) {
        return false;
    }
    r->next = 2 * so_far->iterations;
    return true;
}

/* Takes out what the excess proves; returns how far the scaled bound was below the best energy. */
static int64_t tighten(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    int64_t room, energy = so_far->energy;
    qs_trws_excess(state, r->excess, r->shares);
    int64_t bound =
        energy - qs_eliminate_above(&r->sets, r->excess, r->shares, state->scale.shift, &room);
    so_far->lower_bound = bound > so_far->lower_bound ? bound : so_far->lower_bound;
    so_far->energy = qs_model_energy(&r->sets.model, r->sets.labelling);
    r->looked = so_far->energy - so_far->lower_bound;
    r->looked_at = so_far->iterations;
    if (r->sets.left_count < state->model->sites / FEW) {
        qs_trws_visit_only(state, r->sets.left, r->sets.left_count);
    }
    count(r);
    return room;
}

static bool at_target(const reducer *r)
{
    return r->target > 0 && r->so_far.variables <= r->target;
}

/* Iterations between two looks; false = the limit is reached, or the watch has had enough. */
static bool go_on(reducer *r, qs_trws_state *state, qs_solution *so_far)
{
    uint64_t end = so_far->iterations + BETWEEN + so_far->iterations / BETWEEN;
    bool more = true;
    while (more && so_far->iterations < end && so_far->iterations < r->iterations) {
        qs_trws_iterate(state, 1);
        so_far->iterations++;
        qs_progress now = {so_far->energy, so_far->lower_bound, so_far->iterations};
        more = tell(r, &now);
    }
    return more && so_far->iterations < r->iterations;
}

/* The best labelling is proven as soon as the bound is above its energy less one. What it lacks
 * still lets labels stay that are in no optimum; at 0 ties alone are left. */
static void finish(reducer *r, qs_trws_state *state, qs_solution *so_far, int64_t room)
{
    bool more = so_far->iterations < r->iterations;
    for (int64_t before = INT64_MAX;
         more && room > 0 && room <= before / 16 * 15 && r->so_far.open > 0 && !at_target(r);) {
        before = room;
        more = go_on(r, state, so_far);
        room = tighten(r, state, so_far);
    }
}

static bool between(void *context, qs_trws_state *state, qs_solution *so_far, bool stopped)
{
    reducer *r = context;
    if (!at_target(r) && is_due(r, state, so_far, stopped)) {
        int64_t room = tighten(r, state, so_far);
        if (so_far->energy == so_far->lower_bound && !stopped) {
            finish(r, state, so_far, room);
        }
    }
    return !at_target(r);
}

/* Parts of the workspace, each on a multiple of 16. */
typedef struct layout {
    uint64_t shares, excess, best, end;
} layout;

static layout lay_out(const qs_model *model)
{
    uint64_t best = qs_best_workspace(model);
    layout l = {.shares = qs_rounded(qs_eliminate_workspace(model))};
    l.excess = l.shares + qs_rounded(sizeof(int64_t) * model->sites);
    l.best = l.excess + qs_rounded(sizeof(uint32_t) * qs_trws_excess_numbers(model));
    l.end = best < SIZE_MAX ? l.best + best : SIZE_MAX;
    return l;
}

size_t qs_reduce_workspace(const qs_model *model)
{
    return qs_size(lay_out(model).end);
}

qs_status qs_reduce(const qs_model *model, const qs_reduce_options *options, void *workspace,
                    size_t workspace_size, uint8_t *kept, uint16_t *labelling,
                    qs_reduction *reduction)
{
    if (!model || !workspace || !kept || !labelling || !reduction) {
        return QS_E_ARGUMENT;
    }
    layout l = lay_out(model);
    if (workspace_size < l.end || l.end >= SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    char *base = workspace;
    reducer r = {.options = options,
                 .iterations = ITERATIONS,
                 .excess = (uint32_t *)(void *)(base + l.excess),
                 .next = FIRST,
                 .looked = INT64_MAX};
    if (options) {
        r.iterations = options->iterations > 0 ? options->iterations : ITERATIONS;
        r.target = options->target;
    }
    r.shares = (int64_t *)(void *)(base + l.shares);
    qs_eliminate_begin(&r.sets, model, options && options->walls, workspace, kept, labelling);
    count(&r);
    qs_solve_options watched = {.iterations = r.iterations, .watch = tell, .context = &r};
    qs_guest guest = {between, &r};
    qs_solution solution;
    qs_status status = qs_best_with(&r.sets.model, &watched, &guest, base + l.best,
                                    (size_t)(l.end - l.best), labelling, &solution);
    if (status == QS_OK) {
        r.so_far.upper_bound = solution.energy;
        r.so_far.lower_bound = solution.lower_bound;
        r.so_far.iterations = solution.iterations;
        *reduction = r.so_far;
    }
    return status;
}
