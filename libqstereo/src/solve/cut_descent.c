#include "cut_descent.h"

#include <string.h>

#include "../base/minmax.h"
#include "../model/neighbours.h"
#include "mover.h"
#include "progress.h"

#define RANGE ((int64_t)1 << 30) /* of an excess, whatever flows: twice that fits */

typedef struct descent {
    qs_mover m;
    const qs_solve_options *options;
    qs_solution *solution;
    int32_t step; /* of the present move */
} descent;

size_t qs_descent_workspace(const qs_model *model)
{
    qs_arena arena = {0};
    qs_mover mover = {.model = model};
    qs_mover_take(&mover, &arena);
    return qs_arena_size(&arena);
}

/* Twice what a site's edges can cost, as excess and as capacities, and its unary costs. */
static bool in_range(const qs_model *model)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * model->labels;
        int32_t largest = 0;
        for (uint32_t a = 0; a < model->labels; a++) {
            largest = qs_max_i32(largest, costs[a]);
        }
        if (largest >= RANGE / 2 || qs_most_of_edges(model, p) >= RANGE / 8) {
            return false;
        }
    }
    return true;
}

static bool watch_cut(void *context)
{
    descent *d = context;
    return qs_report_progress(d->options, d->solution);
}

/* Whether site p may take part in the move. */
static bool can_move(const descent *d, uint32_t p)
{
    int64_t to = (int64_t)d->m.x[p] + d->step;
    return to >= 0 && to < d->m.model->labels &&
           (!d->m.model->kept || d->m.model->kept[(size_t)p * d->m.model->labels + (size_t)to]);
}

/* The edge of sites p and q, p < q, whose arcs' residuals are *out and *in. A site that cannot move
 * has no arcs. */
static void load_edge(descent *d, uint32_t p, uint32_t q, int32_t weight, int32_t *out, int32_t *in)
{
    int64_t a = d->m.x[p], b = d->m.x[q], p_to = a + d->step, q_to = b + d->step;
    bool p_moves = can_move(d, p), q_moves = can_move(d, q);
    const qs_model *model = d->m.model;
    int64_t stay = qs_model_pairwise(model, (uint32_t)a, (uint32_t)b), p_alone = 0, q_alone = 0;
    if (p_moves) {
        p_alone = qs_model_pairwise(model, (uint32_t)p_to, (uint32_t)b) - stay;
    }
    if (q_moves) {
        q_alone = qs_model_pairwise(model, (uint32_t)a, (uint32_t)q_to) - stay;
    }
    *out = *in = 0;
    if (p_moves && q_moves) {
        /* Together they cost what they did. */
        int64_t apart = p_alone + q_alone;
        *out = (int32_t)(weight * (apart - apart / 2));
        *in = (int32_t)(weight * (apart / 2));
    }
    d->m.cut.excess[p] += p_moves ? *out - (int32_t)(weight * p_alone) : 0;
    d->m.cut.excess[q] += q_moves ? *in - (int32_t)(weight * q_alone) : 0;
}

static void load_grid(descent *d)
{
    const qs_model *model = d->m.model;
    size_t sites = model->sites, width = model->width;
    int32_t *right = d->m.cut.residual, *left = right + sites, *down = left + sites,
            *up = down + sites;
    memset(right, 0, sizeof *right * 4 * sites);
    for (uint32_t p = 0; p < model->sites; p++) {
        if (model->right[p] != 0) {
            load_edge(d, p, p + 1, model->right[p], &right[p], &left[p + 1]);
        }
        if (model->down[p] != 0) {
            load_edge(d, p, p + model->width, model->down[p], &down[p], &up[p + width]);
        }
    }
}

static void load_graph(descent *d)
{
    const qs_model *model = d->m.model;
    int32_t *residual = d->m.cut.residual;
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            const qs_link *link = &model->links[n];
            if (link->site > p) {
                load_edge(d, p, link->site, link->weight, &residual[n], &residual[d->m.sister[n]]);
            }
        }
    }
}

static void load_move(descent *d)
{
    const qs_model *model = d->m.model;
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * model->labels;
        d->m.cut.node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
        d->m.cut.excess[p] = can_move(d, p) ? costs[d->m.x[p]] - costs[d->m.x[p] + d->step] : 0;
    }
    if (model->width > 0) {
        load_grid(d);
    } else {
        load_graph(d);
    }
}

/* A site that moves has passed its excess on, or gains by what is left of it. */
static int64_t take_move(descent *d)
{
    int64_t gain = 0;
    for (uint32_t p = 0; p < d->m.model->sites; p++) {
        gain += qs_max_i32(d->m.cut.excess[p], 0);
    }
    for (uint32_t p = 0; gain > 0 && p < d->m.model->sites; p++) {
        if (qs_cut_in_tree(&d->m.cut.node[p])) {
            d->m.x[p] = (uint16_t)(d->m.x[p] + d->step);
        }
    }
    return gain;
}

/* The best move by the step; *gain = by how much F falls. False where the watch ends it. */
static bool move(descent *d, int32_t step, int64_t *gain)
{
    *gain = 0;
    d->step = step;
    load_move(d);
    qs_cut_begin(&d->m.cut);
    qs_cut_spread(&d->m.cut);
    for (uint32_t p = 0; p < d->m.model->sites; p++) {
        if (d->m.cut.excess[p] > 0) {
            qs_cut_source(&d->m.cut, p);
        }
    }
    if (!qs_cut_run(&d->m.cut)) {
        return false;
    }
    *gain = take_move(d);
    d->solution->energy -= *gain;
    d->solution->iterations++;
    return true;
}

/* Steps up and down in turn, until both have failed: the labelling is optimal for steps of 1. */
static bool descend(descent *d, int32_t step)
{
    int failed = 0;
    for (int32_t way = 1; failed < 2; way = -way) {
        int64_t gain;
        if (!move(d, way * step, &gain)) {
            return false;
        }
        failed = gain > 0 ? 0 : failed + 1;
        bool proven = step == 1 && failed == 2;
        d->solution->lower_bound = proven ? d->solution->energy : QS_NO_BOUND;
        bool more = qs_report_progress(d->options, d->solution) &&
                    !qs_limit_reached(d->options, d->solution, 0);
        if (!more && !proven) {
            return false;
        }
    }
    return true;
}

qs_status qs_descent(const qs_model *model, const qs_solve_options *options, void *workspace,
                     uint16_t *labelling, qs_solution *solution)
{
    if (!in_range(model)) {
        return QS_E_OVERFLOW;
    }
    qs_arena arena = {.base = workspace};
    descent d = {.m = {.model = model, .x = labelling}, .options = options, .solution = solution};
    (void)qs_take_kept_everywhere(model, labelling);
    qs_mover_take(&d.m, &arena);
    qs_mover_start(&d.m);
    d.m.cut.going = watch_cut;
    d.m.cut.context = &d;
    *solution = (qs_solution){.energy = d.m.energy, .lower_bound = QS_NO_BOUND};
    int32_t step = 1;
    while (2 * step < (int32_t)model->labels) {
        step *= 2;
    }
    while (step > 0 && descend(&d, step)) {
        step /= 2;
    }
    solution->converged = step == 0;
    return QS_OK;
}
