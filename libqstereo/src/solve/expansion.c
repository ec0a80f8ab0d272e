#include "../../include/qstereo/solve.h"

#include <string.h>

#include "../base/simd.h"
#include "../model/metric.h"
#include "../model/neighbours.h"
#include "fusion.h"
#include "mover.h"
#include "progress.h"
#include "solve_64.h"

/* Expansion keeps a reparametrisation of the energy from move to move (Komodakis and Tziritas 2007,
 * PD3; there for approximation, here only for speed: each move is the exact minimum cut). An edge
 * pq of weight w has a dual y(a) for each label a, and with
 *
 *     height_p(a) = unary_p(a) + sum over edges p is first of: y(a), second of: -y(a)
 *     rest_pq(a, b) = w V(a, b) - y(a) + y(b)
 *
 * F = constant + sum_p height_p(x_p) + sum_pq rest_pq(x_p, x_q) for every y. Two things always hold
 * of the present labelling x: rest_pq(x_p, x_q) = 0, so F is the sum of the heights; and rest_pq(a,
 * a) = 0. A move to `a` first puts every y(a) between
 *
 *     low = y(x_p) - w V(x_p, a)    and    high = y(x_q) + w V(a, x_q)
 *
 * (low <= high is the triangle inequality), for then rest_pq(x_p, a) and rest_pq(a, x_q) are not
 * negative, and they are the capacities of the edge's two arcs; the excess of p is height_p(x_p) -
 * height_p(a). A flow is a change of y(a) between low and high. Across the cut it is at its end,
 * which makes the rest 0 again. After the move no site that did not take `a` has an excess: so
 * where neither a site nor a neighbour has changed since, the next move to `a` has no source, and
 * its numbers are not even looked at. */

enum {
    CHUNK = 64, /* sites looked at together */
    MUCH = 4 /* if more than one chunk in MUCH has changed, flow is sent ahead of the search */
};

typedef struct expansion {
    qs_mover m;
    uint32_t chunks;
    qs_number *height; /* labels x sites */
    qs_number *dual; /* labels x edges; of a grid the edges to the right, then those down */
    qs_number *now; /* height of each site's present label */
    /* y of each edge: of the present label of its first site, and of its second. */
    qs_number *first, *second;
    uint64_t *changed; /* of each chunk: when a label in it or next to it changed last */
    /* Of the present move: */
    uint16_t label;
    qs_number *label_height, *label_dual; /* the label's rows of height and dual */
    qs_number *row; /* V(label, .) */
    qs_look look; /* at the watch, within a move */
    uint32_t *loaded, loaded_count; /* the chunks that have been loaded */
} expansion;

static uint64_t edge_count(const qs_model *model)
{
    return qs_is_grid(model) ? 2 * (uint64_t)model->sites : model->edges;
}

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_expansion(expansion *e, const qs_model *model, void *workspace)
{
    qs_arena arena = {.base = workspace};
    e->m.model = model;
    e->chunks = model->sites / CHUNK + (model->sites % CHUNK > 0);
    qs_mover_take(&e->m, &arena);
    uint64_t labels = model->labels, edges = edge_count(model);
    e->height = qs_arena_take(&arena, model->sites * labels, sizeof *e->height);
    e->dual = qs_arena_take(&arena, edges, labels * sizeof *e->dual);
    e->now = qs_arena_take(&arena, model->sites, sizeof *e->now);
    e->first = qs_arena_take(&arena, edges, sizeof *e->first);
    e->second = qs_arena_take(&arena, edges, sizeof *e->second);
    e->row = qs_arena_take(&arena, labels, sizeof *e->row);
    e->changed = qs_arena_take(&arena, e->chunks, sizeof *e->changed);
    e->loaded = qs_arena_take(&arena, e->chunks, sizeof *e->loaded);
    return qs_arena_size(&arena);
}

size_t qs_expansion_workspace(const qs_model *model)
{
    if (!qs_is_metric(model)) {
        return qs_fusion_moves_workspace(model);
    }
    if (qs_times_in_range(model) < QS_TIMES_NEEDED) {
        return QS_IN_64_BITS(SIZE_MAX, qs_expansion_workspace, model);
    }
    expansion e;
    return take_expansion(&e, model, NULL);
}

static uint32_t chunk_end(const expansion *e, uint32_t chunk)
{
    uint32_t begin = chunk * CHUNK;
    return e->m.model->sites - begin < CHUNK ? e->m.model->sites : begin + CHUNK;
}

/* Puts half of an edge's cost on each side, which makes its rest 0. */
static void start_edge(expansion *e, size_t edge, int32_t weight, uint32_t p, uint32_t q)
{
    size_t sites = e->m.model->sites, edges = (size_t)edge_count(e->m.model);
    uint16_t a = e->m.x[p], b = e->m.x[q];
    qs_number cost = (qs_number)(weight * qs_model_pairwise(e->m.model, a, b));
    qs_number near = cost - cost / 2, far = -(cost / 2);
    e->first[edge] = near;
    e->second[edge] = far;
    if (a != b) {
        e->dual[a * edges + edge] = near;
        e->dual[b * edges + edge] = far;
        e->height[a * sites + p] += near;
        e->height[a * sites + q] -= near;
        e->height[b * sites + p] += far;
        e->height[b * sites + q] -= far;
    }
}

static void start_grid_edges(expansion *e)
{
    const qs_model *model = e->m.model;
    for (uint32_t p = 0; p < model->sites; p++) {
        if (model->right[p] != 0) {
            start_edge(e, p, model->right[p], p, p + 1);
        }
        if (model->down[p] != 0) {
            start_edge(e, (size_t)model->sites + p, model->down[p], p, p + model->width);
        }
    }
}

static void start_graph_edges(expansion *e)
{
    const qs_model *model = e->m.model;
    for (uint32_t p = 0; p < model->sites; p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            const qs_link *link = &model->links[n];
            if (link->site > p) {
                start_edge(e, link->edge, link->weight, p, link->site);
            }
        }
    }
}

/* Sets all duals anew, from the present labelling. Every chunk counts as changed. Returns false if
 * the watch has stopped it. */
static bool start_duals(expansion *e)
{
    const qs_model *model = e->m.model;
    size_t sites = model->sites, labels = model->labels, edges = (size_t)edge_count(model);
    for (uint32_t p = 0; p < model->sites && qs_look_at(&e->look, p, labels); p++) {
        for (size_t a = 0; a < labels; a++) {
            e->height[a * sites + p] = model->unary[p * labels + a];
        }
    }
    if (!qs_clear(&e->look, e->dual, sizeof *e->dual * edges * labels)) {
        return false;
    }
    memset(e->first, 0, sizeof *e->first * edges);
    memset(e->second, 0, sizeof *e->second * edges);
    if (qs_is_grid(model)) {
        start_grid_edges(e);
    } else {
        start_graph_edges(e);
    }
    for (size_t p = 0; p < sites; p++) {
        e->now[p] = e->height[e->m.x[p] * sites + p];
    }
    for (uint32_t c = 0; c < e->chunks; c++) {
        e->changed[c] = e->m.now;
    }
    return true;
}

/* Edges of a grid whose first sites are neighbours: what the three passes over a chunk need of
 * each. The bounds of a dual:
 *
 *     first - weight V(x_p, label) <= dual <= second + weight V(label, x_q) */
typedef struct edge_run {
    uint32_t count;
    const uint16_t *x_p, *x_q;
    const int32_t *weight;
    const qs_number *first, *second;
    qs_number *dual, *height_p, *height_q, *out, *in;
} edge_run;

/* The edges to the right of sites begin .. end - 1, or those down, as far as there are any. */
static edge_run run_of(const expansion *e, bool down, uint32_t begin, uint32_t end)
{
    const qs_model *model = e->m.model;
    uint32_t step = down ? model->width : 1, last = model->sites - step;
    size_t at = down ? (size_t)model->sites + begin : begin;
    qs_number *residual = e->m.cut.residual + (down ? 2 * (size_t)model->sites : 0) + begin;
    end = end < last ? end : last;
    return (edge_run){.count = begin < end ? end - begin : 0,
                      .x_p = e->m.x + begin,
                      .x_q = e->m.x + begin + step,
                      .weight = (down ? model->down : model->right) + begin,
                      .first = e->first + at,
                      .second = e->second + at,
                      .dual = e->label_dual + at,
                      .height_p = e->label_height + begin,
                      .height_q = e->label_height + begin + step,
                      .out = residual,
                      .in = residual + model->sites + step};
}

/* weight V(x, label) */
QS_KERNEL qs_number apart(const expansion *e, bool potts, int32_t weight, uint16_t x)
{
    return potts ? (x != e->label ? weight : 0) : weight * e->row[x];
}

/* Puts the duals between their bounds. */
QS_KERNEL void settle_run(expansion *e, bool potts, const edge_run *run)
{
    qs_number shift[CHUNK], *restrict dual = run->dual;
    for (uint32_t i = 0; i < run->count; i++) {
        qs_number low = run->first[i] - apart(e, potts, run->weight[i], run->x_p[i]);
        qs_number high = run->second[i] + apart(e, potts, run->weight[i], run->x_q[i]);
        qs_number to = dual[i] > high ? high : dual[i];
        to = to < low ? low : to;
        shift[i] = to - dual[i];
        dual[i] = to;
    }
    for (uint32_t i = 0; i < run->count; i++) {
        run->height_p[i] += shift[i];
    }
    for (uint32_t i = 0; i < run->count; i++) {
        run->height_q[i] -= shift[i];
    }
}

QS_KERNEL void load_run(const expansion *e, bool potts, const edge_run *run)
{
    qs_number *restrict out = run->out, *restrict in = run->in;
    for (uint32_t i = 0; i < run->count; i++) {
        out[i] = run->second[i] + apart(e, potts, run->weight[i], run->x_q[i]) - run->dual[i];
        in[i] = run->dual[i] - run->first[i] + apart(e, potts, run->weight[i], run->x_p[i]);
    }
}

QS_KERNEL void store_run(const expansion *e, bool potts, const edge_run *run)
{
    qs_number *restrict dual = run->dual;
    for (uint32_t i = 0; i < run->count; i++) {
        dual[i] = run->second[i] + apart(e, potts, run->weight[i], run->x_q[i]) - run->out[i];
    }
}

/* The passes over the edges of a chunk. */
typedef enum pass {
    SETTLE, /* put the duals between their bounds */
    LOAD, /* make the residuals of the cut from the duals */
    STORE /* make the duals from the residuals */
} pass;

QS_KERNEL void pass_run(expansion *e, bool potts, pass what, const edge_run *run)
{
    switch (what) {
    case SETTLE: settle_run(e, potts, run); break;
    case LOAD: load_run(e, potts, run); break;
    case STORE: store_run(e, potts, run); break;
    }
}

static void pass_grid(expansion *e, pass what, bool down, uint32_t begin, uint32_t end)
{
    edge_run run = run_of(e, down, begin, end);
    if (e->m.model->pairwise.smoothness == QS_POTTS) {
        pass_run(e, true, what, &run);
    } else {
        pass_run(e, false, what, &run);
    }
}

/* One pass over the edge of a link from p to a later site. */
static void pass_link(expansion *e, pass what, uint32_t p, uint32_t n)
{
    const qs_link *link = &e->m.model->links[n];
    edge_run run = {1,
                    e->m.x + p,
                    e->m.x + link->site,
                    &link->weight,
                    e->first + link->edge,
                    e->second + link->edge,
                    e->label_dual + link->edge,
                    e->label_height + p,
                    e->label_height + link->site,
                    e->m.cut.residual + n,
                    e->m.cut.residual + e->m.sister[n]};
    pass_run(e, false, what, &run);
}

/* One pass over the edges whose first site is in the chunk; loading, over those whose second one
 * is, too. */
static void pass_chunk(expansion *e, pass what, uint32_t chunk)
{
    const qs_model *model = e->m.model;
    uint32_t begin = chunk * CHUNK, end = chunk_end(e, chunk), width = model->width;
    if (qs_is_grid(model)) {
        pass_grid(e, what, false, begin, end);
        pass_grid(e, what, true, begin, end);
        if (what == LOAD) {
            pass_grid(e, LOAD, false, begin > 0 ? begin - 1 : 0, begin);
            pass_grid(e, LOAD, true, begin > width ? begin - width : 0,
                      end > width ? end - width : 0);
        }
        return;
    }
    for (uint32_t p = begin; p < end; p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            if (model->links[n].site > p) {
                pass_link(e, what, p, n);
            } else if (what == LOAD) {
                pass_link(e, what, model->links[n].site, e->m.sister[n]);
            }
        }
    }
}

static void load_chunk(expansion *e, uint32_t chunk)
{
    e->loaded[e->loaded_count++] = chunk;
    for (uint32_t p = chunk * CHUNK; p < chunk_end(e, chunk); p++) {
        e->m.cut.node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
        e->m.cut.excess[p] = e->now[p] - e->label_height[p];
    }
    pass_chunk(e, LOAD, chunk);
}

static void load(void *context, uint32_t node)
{
    load_chunk(context, node / CHUNK);
}

/* What the flow made of the duals and heights of the label. */
static void store_chunk(expansion *e, uint32_t chunk)
{
    for (uint32_t p = chunk * CHUNK; p < chunk_end(e, chunk); p++) {
        e->label_height[p] = e->now[p] - e->m.cut.excess[p];
    }
    pass_chunk(e, STORE, chunk);
}

/* Site p of a grid takes the label: tells its edges, and the chunks of its neighbours. */
static void tell_grid(expansion *e, uint32_t p)
{
    const qs_model *model = e->m.model;
    uint32_t width = model->width;
    size_t down = (size_t)model->sites + p;
    e->first[p] = e->label_dual[p];
    e->first[down] = e->label_dual[down];
    if (p + 1 < model->sites) {
        e->changed[(p + 1) / CHUNK] = e->m.now;
    }
    if (p > 0) {
        e->second[p - 1] = e->label_dual[p - 1];
        e->changed[(p - 1) / CHUNK] = e->m.now;
    }
    if (model->sites - p > width) {
        e->changed[(p + width) / CHUNK] = e->m.now;
    }
    if (p >= width) {
        e->second[down - width] = e->label_dual[down - width];
        e->changed[(p - width) / CHUNK] = e->m.now;
    }
}

static void tell_graph(expansion *e, uint32_t p)
{
    const qs_model *model = e->m.model;
    for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
        const qs_link *link = &model->links[n];
        qs_number *present = link->site > p ? e->first : e->second;
        present[link->edge] = e->label_dual[link->edge];
        e->changed[link->site / CHUNK] = e->m.now;
    }
}

static void take_label(expansion *e, uint32_t p)
{
    e->m.energy += e->label_height[p] - e->now[p];
    e->m.x[p] = e->label;
    e->now[p] = e->label_height[p];
    e->changed[p / CHUNK] = e->m.now;
    if (qs_is_grid(e->m.model)) {
        tell_grid(e, p);
    } else {
        tell_graph(e, p);
    }
}

/* Before a pass over a chunk: false if the watch stops it. */
static bool go_on(expansion *e, uint32_t chunk)
{
    enum { EACH = 2 }; /* a site or a link takes as long as so many numbers */
    const qs_model *model = e->m.model;
    uint32_t begin = chunk * CHUNK, end = chunk_end(e, chunk);
    uint64_t links = qs_is_grid(model) ? 0 : model->link_start[end] - model->link_start[begin];
    return qs_look_up(&e->look, EACH * (CHUNK + links));
}

/* Loads what has changed since the last move to the label, or everything where that is much. Then
 * names the sources to the cut. */
static void find_sources(expansion *e)
{
    uint64_t since = e->m.now - e->m.model->labels;
    uint32_t changed = 0;
    for (uint32_t c = 0; c < e->chunks && go_on(e, c); c++) {
        if (e->changed[c] > since) {
            pass_chunk(e, SETTLE, c);
            changed++;
        }
    }
    bool all = changed > e->chunks / MUCH;
    for (uint32_t c = 0; c < e->chunks && go_on(e, c); c++) {
        if (all || e->changed[c] > since) {
            load_chunk(e, c);
        }
    }
    if (all) {
        qs_cut_spread(&e->m.cut);
    }
    for (uint32_t i = 0, end = e->loaded_count; i < end; i++) {
        for (uint32_t p = e->loaded[i] * CHUNK; p < chunk_end(e, e->loaded[i]); p++) {
            if (e->m.cut.excess[p] > 0) {
                qs_cut_source(&e->m.cut, p);
            }
        }
    }
}

/* Makes the best move to the label. Returns true if it lowered the energy, false if not or if it
 * was stopped. */
static bool expand(expansion *e, uint16_t label)
{
    const qs_model *model = e->m.model;
    int64_t before = e->m.energy;
    e->label = label;
    e->label_height = e->height + (size_t)label * model->sites;
    e->label_dual = e->dual + (size_t)label * (size_t)edge_count(model);
    e->loaded_count = 0;
    for (uint32_t b = 0; b < model->labels; b++) {
        e->row[b] = (qs_number)qs_model_pairwise(model, label, b);
    }
    qs_cut_begin(&e->m.cut);
    find_sources(e);
    if (e->look.stopped || !qs_cut_run(&e->m.cut)) {
        return false;
    }
    for (uint32_t i = 0; i < e->loaded_count; i++) {
        store_chunk(e, e->loaded[i]);
    }
    for (uint32_t i = 0; i < e->loaded_count; i++) {
        for (uint32_t p = e->loaded[i] * CHUNK; p < chunk_end(e, e->loaded[i]); p++) {
            if (qs_cut_in_tree(&e->m.cut.node[p])) {
                take_label(e, p);
            }
            e->m.cut.node[p].parent = QS_CUT_UNLOADED;
        }
    }
    return e->m.energy < before;
}

/* Goes round the labels until as many moves in a row have failed as there are labels. */
static void expand_all(expansion *e, const qs_solve_options *options, int64_t times,
                       qs_solution *solution)
{
    uint32_t labels = e->m.model->labels, failed = 0;
    uint64_t limit = options && options->iterations ? options->iterations : UINT64_MAX;
    int64_t reached = 1;
    bool going = true;
    while (going && failed < labels && solution->iterations < limit) {
        solution->iterations++;
        for (uint32_t a = 0; going && a < labels && failed < labels; a++) {
            /* A move adds at most the pairwise costs once more to a dual. */
            if (++reached > times) {
                going = start_duals(e);
                reached = 2;
            }
            if (going) {
                failed = expand(e, (uint16_t)a) ? 0 : failed + 1;
                e->m.now++;
                solution->energy = e->m.energy;
                going = !e->look.stopped && qs_report_progress(options, solution);
                e->look.done = 0;
            }
        }
    }
    solution->converged = failed >= labels && !e->look.stopped;
    solution->energy = e->m.energy;
}

qs_status qs_expansion(const qs_model *model, const qs_solve_options *options, void *workspace,
                       size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (!qs_is_metric(model)) {
        return qs_fusion_moves(QS_FUSION_EXPANSION, model, options, workspace, workspace_size,
                               labelling, solution);
    }
    int64_t times = qs_times_in_range(model);
    if (times < QS_TIMES_NEEDED) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_expansion, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    expansion e = {.m.x = labelling, .m.now = 2 * (uint64_t)model->labels};
    size_t size = take_expansion(&e, model, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    qs_mover_start(&e.m);
    e.m.cut.load = load;
    e.m.cut.look = &e.look;
    e.m.cut.context = &e;
    *solution = (qs_solution){.energy = e.m.energy, .lower_bound = QS_NO_BOUND};
    qs_reporter reporter = {options, solution};
    e.look = (qs_look){.going = qs_report_now, .context = &reporter};
    if (start_duals(&e)) {
        expand_all(&e, options, times, solution);
    }
    solution->energy -= qs_take_kept_everywhere(model, labelling);
    return QS_OK;
}
