#include "cut_descent.h"

#include <string.h>

#include "../base/minmax.h"
#include "../model/neighbours.h"
#include "flow_split.h"
#include "fusion.h"
#include "progress.h"

static void take_parts(qs_fusion *f, qs_flow_split *split, const qs_model *model, qs_arena *arena)
{
    f->m.model = model;
    qs_fusion_take(f, arena);
    qs_flow_split_take(split, model, arena);
}

size_t qs_descent_workspace(const qs_model *model)
{
    qs_arena arena = {0};
    qs_fusion f = {.solution = NULL};
    qs_flow_split split;
    take_parts(&f, &split, model, &arena);
    return qs_arena_size(&arena);
}

/* ---- The proof (docs/MATHS.md, section 19). ----
 *
 * Each edge has a slope s, one of those that its cost has at the labels of its sites. Charge its
 * first site with s times its label, and its second with minus that. Then the edge costs least at
 * these labels; and so does each site, if its slopes add up to a number between two bounds. To find
 * such slopes is a flow: from p to q it lowers the slope of their edge, and what p is charged. */

/* Above all that the edges of a site can have in slopes (qs_fusion_fits). */
#define UNBOUNDED (QS_NUMBER_MAX / 4 + 1)

/* The largest slope of an edge, and the smallest: what V rises by from the difference of the labels
 * on, and up to it. */
typedef struct slopes {
    int64_t least, most;
} slopes;

static int64_t value_at(const qs_model *model, int64_t apart)
{
    return qs_model_pairwise(model, apart > 0 ? (uint32_t)apart : 0,
                             apart < 0 ? (uint32_t)-apart : 0);
}

static slopes slopes_of(const qs_fusion *f, uint32_t site, const qs_edge_seen *edge)
{
    const qs_model *model = f->m.model;
    int64_t own = f->m.x[site], other = f->m.x[edge->site],
            apart = edge->first ? own - other : other - own, last = (int64_t)model->labels - 1,
            here = value_at(model, apart);
    slopes s = {apart > -last ? here - value_at(model, apart - 1) : 0,
                apart < last ? value_at(model, apart + 1) - here : 0};
    s.least = apart > -last ? s.least : s.most; /* no labels lie farther apart */
    s.most = apart < last ? s.most : s.least;
    return (slopes){edge->weight * s.least, edge->weight * s.most};
}

/* The arc from a site along its edge `at`. */
static qs_number *arc_of(const qs_fusion *f, uint32_t site, uint32_t at, const qs_edge_seen *edge)
{
    const qs_model *model = f->m.model;
    if (model->width == 0) {
        return &f->m.cut.residual[model->link_start[site] + at];
    }
    return &f->m.cut.residual[(size_t)qs_cut_way(edge) * model->sites + site];
}

static void load_slopes(qs_fusion *f)
{
    qs_edge_seen edge;
    for (uint32_t p = 0; p < f->m.model->sites; p++) {
        for (uint32_t at = 0; qs_see_edge(f->m.model, p, at, &edge); at++) {
            if (edge.weight > 0) {
                slopes s = slopes_of(f, p, &edge);
                int64_t first = qs_max_i64(qs_min_i64(0, s.most), s.least);
                *arc_of(f, p, at, &edge) =
                    (qs_number)(edge.first ? first - s.least : s.most - first);
            }
        }
    }
}

static int64_t slope_now(const qs_fusion *f, uint32_t site, uint32_t at, const qs_edge_seen *edge)
{
    slopes s = slopes_of(f, site, edge);
    int64_t residual = *arc_of(f, site, at, edge);
    return edge->first ? s.least + residual : s.most - residual;
}

static int64_t charge_now(const qs_fusion *f, uint32_t site)
{
    int64_t charge = 0;
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(f->m.model, site, at, &edge); at++) {
        int64_t slope = edge.weight > 0 ? slope_now(f, site, at, &edge) : 0;
        charge += edge.first ? slope : -slope;
    }
    return charge;
}

static bool is_label(const qs_model *model, uint32_t site, int64_t label)
{
    return label >= 0 && label < model->labels &&
           (!model->kept || model->kept[(size_t)site * model->labels + (size_t)label]);
}

/* By how much a site is charged more than it may be, or less (below 0). The next higher label
 * bounds the charge from below, the next lower one from above. */
static qs_number excess_of(const qs_fusion *f, uint32_t site, bool above)
{
    const qs_model *model = f->m.model;
    const int32_t *costs = model->unary + (size_t)site * model->labels;
    int64_t label = f->m.x[site], other = above ? label - 1 : label + 1;
    if (!is_label(model, site, other)) {
        return above ? -UNBOUNDED : UNBOUNDED;
    }
    int64_t rise =
        above ? (int64_t)costs[label] - costs[other] : (int64_t)costs[other] - costs[label];
    return (qs_number)qs_max_i64(qs_min_i64(charge_now(f, site) + rise, UNBOUNDED), -UNBOUNDED);
}

/* First what is too much goes where there is room; then what is too little comes from where there
 * is more than enough. */
static void find_slopes(qs_fusion *f)
{
    qs_cut *cut = &f->m.cut;
    load_slopes(f);
    for (int above = 1; above >= 0; above--) {
        for (uint32_t p = 0; p < cut->nodes; p++) {
            cut->node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
            cut->excess[p] = excess_of(f, p, above != 0);
        }
        qs_cut_begin(cut);
        for (uint32_t p = 0; p < cut->nodes; p++) {
            if (cut->excess[p] > 0) {
                qs_cut_source(cut, p);
            }
        }
        if (!qs_cut_run(cut)) {
            return;
        }
    }
}

static void take_slope(const void *context, uint32_t site, uint32_t at, const qs_edge_seen *edge,
                       int64_t *sum)
{
    const qs_fusion *f = context;
    int64_t slope = slope_now(f, site, at, edge);
    for (int64_t a = 0; a < f->m.model->labels; a++) {
        sum[a] += edge->first ? -slope * a : slope * a;
    }
}

static void tell(qs_fusion *f, const qs_flow_split *split)
{
    if (f->options && f->options->witness) {
        memset(f->m.cut.residual, 0,
               sizeof *f->m.cut.residual * (f->m.model->width > 0
                                                ? 4 * (size_t)f->m.model->sites
                                                : f->m.model->link_start[f->m.model->sites]));
        find_slopes(f);
        qs_flow_split_tell(split, f->options, 0, f->m.x, take_slope, f);
    }
}

/* ---- The descent. ---- */

/* Steps up and down in turn, until both have failed: the labelling is optimal for steps of 1. */
static bool descend(qs_fusion *f, int32_t step)
{
    qs_solution *solution = f->solution;
    int failed = 0;
    for (int32_t way = 1; failed < 2; way = -way) {
        int64_t gain;
        qs_propose_jump(f, way * step);
        if (!qs_fuse(f, &gain)) {
            return false;
        }
        failed = gain > 0 ? 0 : failed + 1;
        bool proven = step == 1 && failed == 2;
        solution->iterations++;
        solution->energy = f->m.energy;
        solution->lower_bound = proven ? solution->energy : QS_NO_BOUND;
        bool more =
            qs_report_progress(f->options, solution) && !qs_limit_reached(f->options, solution, 0);
        if (!more && !proven) {
            return false;
        }
    }
    return true;
}

qs_status qs_descent(const qs_model *model, const qs_solve_options *options, void *workspace,
                     uint16_t *labelling, qs_solution *solution)
{
    qs_arena arena = {.base = workspace};
    qs_fusion f = {.m = {.x = labelling}, .options = options, .solution = solution};
    qs_flow_split split;
    (void)qs_take_kept_everywhere(model, labelling);
    take_parts(&f, &split, model, &arena);
    qs_fusion_start(&f);
    *solution = (qs_solution){.energy = f.m.energy, .lower_bound = QS_NO_BOUND};
    int32_t step = 1;
    while (2 * step < (int32_t)model->labels) {
        step *= 2;
    }
    while (step > 0 && descend(&f, step)) {
        step /= 2;
    }
    solution->converged = step == 0;
    tell(&f, &split);
    return QS_OK;
}
