#include "fusion.h"

#include <string.h>

#include "../base/minmax.h"
#include "../model/edge_value.h"
#include "../model/neighbours.h"
#include "progress.h"

void qs_fusion_take(qs_fusion *fusion, qs_arena *arena)
{
    qs_mover_take(&fusion->m, arena);
    fusion->proposal = qs_arena_take(arena, fusion->m.model->sites, sizeof *fusion->proposal);
}

/* What all edges of a site may cost. An excess, whatever flows, is at most four times that and the
 * difference of two unary costs; what flows on its way may be twice that more. */
#define LIMIT (QS_BITS == 64 ? INT64_C(1) << QS_MODEL_BITS : INT64_C(1) << 27)

bool qs_fusion_fits(const qs_model *model)
{
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * model->labels;
        int64_t largest = 0;
        for (uint32_t a = 0; a < model->labels; a++) {
            largest = qs_max_i64(largest, costs[a]);
        }
        if (largest >= QS_NUMBER_MAX / 4 + 1 || qs_most_of_edges(model, p) >= LIMIT) {
            return false;
        }
    }
    return true;
}

void qs_fusion_start(qs_fusion *fusion)
{
    qs_mover_start(&fusion->m);
    fusion->reporter = (qs_reporter){fusion->options, fusion->solution};
    fusion->look = (qs_look){.going = qs_report_now, .context = &fusion->reporter};
    fusion->m.cut.look = &fusion->look;
}

/* Whether the proposal has another label for site p that it may take. */
static bool can_take(const qs_fusion *f, uint32_t p)
{
    const qs_model *model = f->m.model;
    uint16_t label = f->proposal[p];
    return label != f->m.x[p] && (!model->kept || model->kept[(size_t)p * model->labels + label]);
}

/* An edge, seen by its first site p, whose arcs' residuals are *out and *in. A site that can take
 * nothing has no arcs. */
static void load_edge(qs_fusion *f, uint32_t p, const qs_edge_seen *edge, qs_number *out,
                      qs_number *in)
{
    const qs_model *model = f->m.model;
    const uint16_t *x = f->m.x, *to = f->proposal;
    uint32_t q = edge->site, number = edge->edge;
    int32_t weight = edge->weight;
    bool p_takes = can_take(f, p), q_takes = can_take(f, q);
    int64_t keep = qs_edge_value(model, number, x[p], x[q]);
    int64_t p_alone = p_takes ? qs_edge_value(model, number, to[p], x[q]) : keep;
    int64_t q_alone = q_takes ? qs_edge_value(model, number, x[p], to[q]) : keep;
    *out = *in = 0;
    if (p_takes && q_takes) {
        int64_t both = qs_edge_value(model, number, to[p], to[q]);
        keep = qs_min_i64(keep, p_alone + q_alone - both);
        int64_t apart = p_alone + q_alone - keep - both;
        *out = (qs_number)(weight * (apart - apart / 2));
        *in = (qs_number)(weight * (apart / 2));
    }
    f->m.cut.excess[p] += p_takes ? *out - (qs_number)(weight * (p_alone - keep)) : 0;
    f->m.cut.excess[q] += q_takes ? *in - (qs_number)(weight * (q_alone - keep)) : 0;
}

/* Before a site's edges are loaded: false if the watch stops it. */
static bool go_on(qs_fusion *f, uint32_t p)
{
    enum { EDGE_WORK = 8 }; /* in numbers computed */
    return qs_look_up(&f->look, EDGE_WORK * (uint64_t)qs_edges_at(f->m.model, p));
}

static void load_grid(qs_fusion *f)
{
    const qs_model *model = f->m.model;
    size_t sites = model->sites, width = model->width;
    qs_number *right = f->m.cut.residual, *left = right + sites, *down = left + sites,
              *up = down + sites;
    memset(right, 0, sizeof *right * 4 * sites);
    for (uint32_t p = 0; p < model->sites && go_on(f, p); p++) {
        if (model->right[p] != 0) {
            qs_edge_seen edge = {p + 1, model->right[p], qs_cell_edge(p, false), true};
            load_edge(f, p, &edge, &right[p], &left[p + 1]);
        }
        if (model->down[p] != 0) {
            qs_edge_seen edge = {p + model->width, model->down[p], qs_cell_edge(p, true), true};
            load_edge(f, p, &edge, &down[p], &up[p + width]);
        }
    }
}

static void load_graph(qs_fusion *f)
{
    const qs_model *model = f->m.model;
    qs_number *residual = f->m.cut.residual;
    for (uint32_t p = 0; p < model->sites && go_on(f, p); p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            const qs_link *link = &model->links[n];
            if (link->site > p) {
                qs_edge_seen edge = {link->site, link->weight, link->edge, true};
                load_edge(f, p, &edge, &residual[n], &residual[f->m.sister[n]]);
            }
        }
    }
}

static void load_move(qs_fusion *f)
{
    const qs_model *model = f->m.model;
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * model->labels;
        f->m.cut.node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
        f->m.cut.excess[p] = can_take(f, p) ? costs[f->m.x[p]] - costs[f->proposal[p]] : 0;
    }
    if (model->width > 0) {
        load_grid(f);
    } else {
        load_graph(f);
    }
}

/* The sites in the tree take their proposals, if there is excess left: by that much, or more, F
 * falls. */
static int64_t take_move(qs_fusion *f)
{
    bool any = false;
    for (uint32_t p = 0; p < f->m.model->sites; p++) {
        any = any || f->m.cut.excess[p] > 0;
    }
    if (!any) {
        return 0;
    }
    for (uint32_t p = 0; p < f->m.model->sites; p++) {
        f->m.x[p] = qs_cut_in_tree(&f->m.cut.node[p]) ? f->proposal[p] : f->m.x[p];
    }
    int64_t gain = f->m.energy - qs_model_energy(f->m.model, f->m.x);
    f->m.energy -= gain;
    return gain;
}

bool qs_fuse(qs_fusion *fusion, int64_t *gain)
{
    *gain = 0;
    load_move(fusion);
    qs_cut_begin(&fusion->m.cut);
    qs_cut_spread(&fusion->m.cut);
    for (uint32_t p = 0; p < fusion->m.model->sites; p++) {
        if (fusion->m.cut.excess[p] > 0) {
            qs_cut_source(&fusion->m.cut, p);
        }
    }
    if (fusion->look.stopped || !qs_cut_run(&fusion->m.cut)) {
        return false;
    }
    *gain = take_move(fusion);
    return true;
}

enum { FEW_LABELS = 32 };

static const int32_t jumps[QS_JUMPS] = {1, -1, 2, -2, 3, -3, 4, -4, 6, -6, 8, -8, 12, -12};

void qs_propose_jump(qs_fusion *fusion, int32_t step)
{
    int32_t labels = (int32_t)fusion->m.model->labels;
    for (uint32_t p = 0; p < fusion->m.model->sites; p++) {
        int32_t to = fusion->m.x[p] + step;
        fusion->proposal[p] = to >= 0 && to < labels ? (uint16_t)to : fusion->m.x[p];
    }
}

static void propose_label(qs_fusion *f, uint32_t label)
{
    for (uint32_t p = 0; p < f->m.model->sites; p++) {
        f->proposal[p] = (uint16_t)label;
    }
}

/* The sites of two labels take each the other one. */
static void propose_swap(qs_fusion *f, uint32_t pair)
{
    uint32_t a = 1; /* pairs in the order (0, 1), (0, 2), (1, 2), (0, 3) ... */
    while (pair >= a) {
        pair -= a++;
    }
    for (uint32_t p = 0; p < f->m.model->sites; p++) {
        uint16_t x = f->m.x[p];
        f->proposal[p] = x == a ? (uint16_t)pair : x == pair ? (uint16_t)a : x;
    }
}

uint32_t qs_fusion_count(const qs_model *model, qs_fusion_kind kind)
{
    uint32_t labels = model->labels;
    switch (kind) {
    case QS_FUSION_EXPANSION: return labels;
    case QS_FUSION_SWAP: return labels * (labels - 1) / 2;
    case QS_FUSION_JUMPS: break;
    }
    return QS_JUMPS + (labels <= FEW_LABELS ? labels : 0);
}

static void propose(qs_fusion *f, qs_fusion_kind kind, uint32_t at)
{
    if (kind == QS_FUSION_SWAP) {
        propose_swap(f, at);
    } else if (kind == QS_FUSION_EXPANSION || at >= QS_JUMPS) {
        propose_label(f, kind == QS_FUSION_EXPANSION ? at : at - QS_JUMPS);
    } else {
        qs_propose_jump(f, jumps[at]);
    }
}

/* Cycles until as many moves as there are have failed. */
static void cycle(qs_fusion *f, qs_fusion_kind kind)
{
    uint32_t moves = qs_fusion_count(f->m.model, kind), failed = 0;
    bool go = true;
    while (go && failed < moves) {
        f->solution->iterations++;
        for (uint32_t at = 0; go && at < moves && failed < moves; at++) {
            int64_t gain;
            propose(f, kind, at);
            go = qs_fuse(f, &gain);
            failed = gain > 0 ? 0 : failed + go;
            f->solution->energy = f->m.energy;
            go = go && qs_report_progress(f->options, f->solution);
        }
        go = go && !qs_limit_reached(f->options, f->solution, 0);
    }
    f->solution->converged = failed >= moves;
}

size_t qs_fusion_moves_workspace(const qs_model *model)
{
    if (!qs_fusion_fits(model)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_fusion_moves_workspace, model);
    }
    qs_arena arena = {0};
    qs_fusion fusion = {.m = {.model = model}};
    qs_fusion_take(&fusion, &arena);
    return qs_arena_size(&arena);
}

qs_status qs_fusion_moves(qs_fusion_kind kind, const qs_model *model,
                          const qs_solve_options *options, void *workspace, size_t workspace_size,
                          uint16_t *labelling, qs_solution *solution)
{
    if (!qs_fusion_fits(model)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_fusion_moves, kind, model, options, workspace,
                             workspace_size, labelling, solution);
    }
    qs_arena arena = {.base = workspace};
    qs_fusion fusion = {
        .m = {.model = model, .x = labelling}, .options = options, .solution = solution};
    qs_fusion_take(&fusion, &arena);
    if (workspace_size < qs_arena_size(&arena) || qs_arena_size(&arena) == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    (void)qs_take_kept_everywhere(model, labelling);
    qs_fusion_start(&fusion);
    *solution = (qs_solution){.energy = fusion.m.energy, .lower_bound = QS_NO_BOUND};
    cycle(&fusion, kind);
    return QS_OK;
}
