#include "../../include/qstereo/solve.h"

#include "../base/minmax.h"
#include "../model/metric.h"
#include "../model/neighbours.h"
#include "fusion.h"
#include "mover.h"
#include "progress.h"
#include "solve_64.h"

/* A move of the pair (a, b) is a cut on the sites that have one of the two labels; the source side
 * takes b. At the start the edges between these sites carry as much flow as they can in the
 * direction of the present labelling. Then that labelling costs only the terminal arcs that it
 * cuts: where there is none of them it is the best, and no flow is needed. */

enum { RUN = 64 }; /* sites that are skipped together where none of them has a or b */

typedef struct swapper {
    qs_mover m;
    /* Of each label: when its sites, or the labels of their neighbours, changed last. */
    uint64_t *changed;
    /* Of the present move: */
    uint16_t a, b;
    uint32_t *members, member_count; /* the sites that have a or b, in order */
    qs_look look; /* at the watch, within a move */
} swapper;

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_swapper(swapper *s, const qs_model *model, void *workspace)
{
    qs_arena arena = {.base = workspace};
    s->m.model = model;
    qs_mover_take(&s->m, &arena);
    s->changed = qs_arena_take(&arena, model->labels, sizeof *s->changed);
    s->members = qs_arena_take(&arena, model->sites, sizeof *s->members);
    return qs_arena_size(&arena);
}

size_t qs_swap_workspace(const qs_model *model)
{
    if (!qs_is_semi_metric(model)) {
        return qs_fusion_moves_workspace(model);
    }
    if (qs_times_in_range(model) < QS_TIMES_NEEDED) {
        return QS_IN_64_BITS(SIZE_MAX, qs_swap_workspace, model);
    }
    swapper s;
    return take_swapper(&s, model, NULL);
}

static bool is_member(const swapper *s, uint32_t p)
{
    return s->m.x[p] == s->a || s->m.x[p] == s->b;
}

/* Lists the sites with a or b. Most runs of sites have none. */
static void find_members(swapper *s)
{
    uint32_t sites = s->m.model->sites, end;
    s->member_count = 0;
    for (uint32_t begin = 0; begin < sites; begin = end) {
        unsigned any = 0;
        end = begin + qs_min_u32(RUN, sites - begin);
        for (uint32_t p = begin; p < end; p++) {
            any |= is_member(s, p);
        }
        if (any) {
            for (uint32_t p = begin; p < end; p++) {
                s->members[s->member_count] = p;
                s->member_count += is_member(s, p);
            }
        }
    }
}

/* The edge from p to q. Returns what it adds to the excess of p.
 *
 * residual  out: of the arc from p to q */
static qs_number load_swap_arc(const swapper *s, uint32_t p, uint32_t q, qs_number weight,
                               qs_number *residual)
{
    const qs_model *model = s->m.model;
    uint16_t here = s->m.x[p], there = s->m.x[q];
    if (there != s->a && there != s->b) {
        *residual = 0;
        return weight * (qs_number)(qs_model_pairwise(model, s->a, there) -
                                    qs_model_pairwise(model, s->b, there));
    }
    qs_number cost = weight * (qs_number)qs_model_pairwise(model, s->a, s->b);
    if (here == there) {
        *residual = cost;
        return 0;
    }
    /* Full from the site with b to the one with a. */
    *residual = here == s->b ? 0 : 2 * cost;
    return here == s->b ? -cost : cost;
}

/* An edge of a grid. Of weight 0 there is none. */
static qs_number load_grid_arc(const swapper *s, uint32_t p, uint32_t q, int32_t weight, size_t arc)
{
    qs_number *residual = s->m.cut.residual + arc * s->m.model->sites + p;
    return weight != 0 ? load_swap_arc(s, p, q, weight, residual) : 0;
}

/* What all edges of p add to its excess. */
static qs_number load_grid_arcs(const swapper *s, uint32_t p)
{
    const qs_model *model = s->m.model;
    uint32_t width = model->width;
    int32_t left = p > 0 ? model->right[p - 1] : 0, up = p >= width ? model->down[p - width] : 0;
    return load_grid_arc(s, p, p + 1, model->right[p], QS_CUT_RIGHT) +
           load_grid_arc(s, p, p + width, model->down[p], QS_CUT_DOWN) +
           load_grid_arc(s, p, p - 1, left, QS_CUT_LEFT) +
           load_grid_arc(s, p, p - width, up, QS_CUT_UP);
}

static qs_number load_graph_arcs(const swapper *s, uint32_t p)
{
    const qs_model *model = s->m.model;
    qs_number excess = 0;
    for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
        const qs_link *link = &model->links[n];
        excess += load_swap_arc(s, p, link->site, link->weight, &s->m.cut.residual[n]);
    }
    return excess;
}

/* Returns false if the watch stops it. */
static bool load_member(swapper *s, uint32_t p)
{
    enum { EDGE_WORK = 8 }; /* in numbers computed */
    const qs_model *model = s->m.model;
    const int32_t *unary = model->unary + (size_t)p * model->labels;
    qs_number edges = qs_is_grid(model) ? load_grid_arcs(s, p) : load_graph_arcs(s, p);
    s->m.cut.node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
    s->m.cut.excess[p] = (qs_number)unary[s->a] - unary[s->b] + edges;
    return qs_look_up(&s->look, EDGE_WORK * (uint64_t)qs_edges_at(model, p));
}

/* What the terminal arcs cost that the present labelling cuts: from the source to a site with a,
 * and from a site with b to the sink. */
static int64_t terminal_cost(const swapper *s)
{
    int64_t cost = 0;
    for (uint32_t i = 0; i < s->member_count; i++) {
        uint32_t p = s->members[i];
        int64_t excess = s->m.cut.excess[p];
        cost += qs_max_i64(0, s->m.x[p] == s->b ? -excess : excess);
    }
    return cost;
}

static int64_t total_excess(const swapper *s)
{
    int64_t sum = 0;
    for (uint32_t i = 0; i < s->member_count; i++) {
        sum += qs_max_number(0, s->m.cut.excess[s->members[i]]);
    }
    return sum;
}

/* The labels of p's neighbours have another neighbour now. */
static void touch_neighbours(swapper *s, uint32_t p)
{
    const qs_model *model = s->m.model;
    qs_edge_seen edge;
    for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
        s->changed[s->m.x[edge.site]] = s->m.now;
    }
}

static void take_sides(swapper *s)
{
    /* With Potts a neighbour of a third label costs the same on both sides. */
    bool neighbours = s->m.model->pairwise.smoothness != QS_POTTS;
    for (uint32_t i = 0; i < s->member_count; i++) {
        uint32_t p = s->members[i];
        uint16_t to = qs_cut_in_tree(&s->m.cut.node[p]) ? s->b : s->a;
        if (to != s->m.x[p]) {
            s->m.x[p] = to;
            if (neighbours) {
                touch_neighbours(s, p);
            }
        }
    }
    s->changed[s->a] = s->m.now;
    s->changed[s->b] = s->m.now;
}

/* Makes the best move of the pair. Returns true if it lowered the energy; not if it was stopped. */
static bool swap(swapper *s, uint16_t a, uint16_t b)
{
    s->a = a;
    s->b = b;
    find_members(s);
    bool go = true;
    for (uint32_t i = 0; go && i < s->member_count; i++) {
        go = load_member(s, s->members[i]);
    }
    if (!go) {
        return false;
    }
    int64_t cost = terminal_cost(s), lower = 0;
    if (cost > 0) {
        int64_t before = total_excess(s);
        qs_cut_begin(&s->m.cut);
        qs_cut_spread_some(&s->m.cut, s->members, s->member_count);
        for (uint32_t i = 0; i < s->member_count; i++) {
            if (s->m.cut.excess[s->members[i]] > 0) {
                qs_cut_source(&s->m.cut, s->members[i]);
            }
        }
        if (!qs_cut_run(&s->m.cut)) {
            return false;
        }
        lower = cost - (before - total_excess(s));
    }
    if (lower > 0) {
        take_sides(s);
        s->m.energy -= lower;
    }
    for (uint32_t i = 0; i < s->member_count; i++) {
        s->m.cut.node[s->members[i]].parent = QS_CUT_UNLOADED;
    }
    return lower > 0;
}

/* Goes round the pairs until as many moves in a row have failed as there are pairs. */
static void swap_all(swapper *s, const qs_solve_options *options, qs_solution *solution)
{
    uint32_t labels = s->m.model->labels;
    uint64_t limit = options && options->iterations ? options->iterations : UINT64_MAX;
    uint64_t pairs = (uint64_t)labels * (labels - 1) / 2, failed = 0;
    bool going = true;
    while (going && failed < pairs && solution->iterations < limit) {
        solution->iterations++;
        for (uint32_t a = 0; a < labels; a++) {
            for (uint32_t b = a + 1; going && b < labels && failed < pairs; b++) {
                uint64_t since = s->m.now - pairs;
                bool again = s->changed[a] > since || s->changed[b] > since;
                failed = again && swap(s, (uint16_t)a, (uint16_t)b) ? 0 : failed + 1;
                s->m.now++;
                solution->energy = s->m.energy;
                going = !s->look.stopped && qs_report_progress(options, solution);
                s->look.done = 0;
            }
        }
    }
    solution->converged = failed >= pairs && !s->look.stopped;
    solution->energy = s->m.energy;
}

qs_status qs_swap(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (!qs_is_semi_metric(model)) {
        return qs_fusion_moves(QS_FUSION_SWAP, model, options, workspace, workspace_size, labelling,
                               solution);
    }
    if (qs_times_in_range(model) < QS_TIMES_NEEDED) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_swap, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    swapper s = {.m.x = labelling, .m.now = (uint64_t)model->labels * model->labels};
    size_t size = take_swapper(&s, model, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    qs_mover_start(&s.m);
    for (uint32_t a = 0; a < model->labels; a++) {
        s.changed[a] = s.m.now;
    }
    s.m.cut.look = &s.look;
    *solution = (qs_solution){.energy = s.m.energy, .lower_bound = QS_NO_BOUND};
    qs_reporter reporter = {options, solution};
    s.look = (qs_look){.going = qs_report_now, .context = &reporter};
    swap_all(&s, options, solution);
    solution->energy -= qs_take_kept_everywhere(model, labelling);
    return QS_OK;
}
