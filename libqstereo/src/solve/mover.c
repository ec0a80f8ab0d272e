#include "../../include/qstereo/solve.h"

#include <string.h>

#include "../model/neighbours.h"
#include "min_cut.h"
#include "progress.h"

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
    MUCH = 4 /* parts of the chunks of which one makes it worth to send flow ahead */
};

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

#define RANGE ((int64_t)1 << 30) /* of any height: the difference of two fits */

/* Memory in parts, each for any type. */
typedef struct parts {
    char *base; /* NULL = only counting */
    uint64_t used;
    bool full; /* counted beyond all memory */
} parts;

static void *part(parts *memory, uint64_t count, uint64_t size)
{
    uint64_t at = memory->used;
    if (count > (UINT64_MAX / 2 - at) / size) {
        memory->full = true;
        return NULL;
    }
    memory->used = at + (count * size + 15) / 16 * 16;
    return memory->base ? memory->base + at : NULL;
}

static size_t parts_size(const parts *memory)
{
    return memory->full || memory->used > SIZE_MAX - 1 ? SIZE_MAX : (size_t)memory->used;
}

/* What both solvers have. */
typedef struct mover {
    const qs_model *model;
    uint16_t *x;
    qs_cut cut;
    qs_cut_node *padded; /* cut.node with the nodes around it */
    uint32_t *sister; /* of each link, graphs only */
    uint64_t now; /* moves made or passed over, from two cycles up */
    int64_t energy;
} mover;

static bool is_grid(const qs_model *model)
{
    return model->width > 0;
}

static uint64_t link_count(const qs_model *model)
{
    return is_grid(model) ? 0 : 2 * (uint64_t)model->edges;
}

static void take_mover(mover *m, parts *memory)
{
    const qs_model *model = m->model;
    m->padded = part(memory, model->sites + 2 * (uint64_t)model->width, sizeof *m->padded);
    m->cut.excess = part(memory, model->sites, sizeof *m->cut.excess);
    m->cut.residual = part(memory, is_grid(model) ? 4 * (uint64_t)model->sites : link_count(model),
                           sizeof *m->cut.residual);
    m->cut.queue = part(memory, model->sites, sizeof *m->cut.queue);
    m->cut.orphan = part(memory, model->sites, sizeof *m->cut.orphan);
    m->sister = part(memory, link_count(model), sizeof *m->sister);
}

static void start_mover(mover *m)
{
    const qs_model *model = m->model;
    m->cut.nodes = model->sites;
    m->cut.node = m->padded + model->width;
    m->cut.width = model->width;
    m->cut.start = model->link_start;
    m->cut.links = model->links;
    m->cut.sister = m->sister;
    for (size_t i = 0; i < model->sites + 2 * (size_t)model->width; i++) {
        m->padded[i] = (qs_cut_node){.parent = QS_CUT_UNLOADED};
    }
    memset(m->cut.residual, 0,
           sizeof *m->cut.residual *
               (is_grid(model) ? 4 * (size_t)model->sites : (size_t)link_count(model)));
    if (!is_grid(model)) {
        qs_cut_find_sisters(model->link_start, model->links, model->sites, m->sister,
                            m->cut.queue);
    }
    m->energy = qs_model_energy(model, m->x);
}

/* The sum of the weights of the edges of site p, and the largest unary cost: what its heights can
 * reach. */
static int64_t incident_weight(const qs_model *model, uint32_t p)
{
    int64_t sum = 0;
    if (is_grid(model)) {
        uint32_t width = model->width;
        return (int64_t)model->right[p] + model->down[p] + (p > 0 ? model->right[p - 1] : 0) +
               (p >= width ? model->down[p - width] : 0);
    }
    for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
        sum += model->links[n].weight;
    }
    return sum;
}

/* How many times all pairwise costs of a site may come upon its unary cost until they leave the
 * range; the least over all sites. */
static int64_t times_in_range(const qs_model *model)
{
    int64_t times = INT64_MAX;
    for (uint32_t p = 0; p < model->sites; p++) {
        int64_t unary = 0, weight = incident_weight(model, p);
        for (uint32_t a = 0; a < model->labels; a++) {
            int32_t cost = model->unary[(size_t)p * model->labels + a];
            unary = cost > unary ? cost : unary;
        }
        if (unary >= RANGE || weight >= RANGE) {
            return 0;
        }
        if (weight > 0 && model->pairwise_max > 0) {
            int64_t most = (RANGE - 1 - unary) / weight / model->pairwise_max;
            times = most < times ? most : times;
        }
    }
    return times;
}

/* V(a, a) = 0 and V(a, b) = V(b, a). */
static bool is_semi_metric(const qs_model *model)
{
    uint32_t labels = model->labels;
    const int32_t *table = model->pairwise.table;
    if (model->pairwise.smoothness != QS_TABLE) {
        return true;
    }
    for (size_t a = 0; a < labels; a++) {
        for (size_t b = 0; b < a; b++) {
            if (table[a * labels + b] != table[b * labels + a] || table[a * labels + b] < 0) {
                return false;
            }
        }
        if (table[a * labels + a] != 0) {
            return false;
        }
    }
    return true;
}

/* V(a, c) <= V(a, b) + V(b, c) in a table that is a semi-metric. */
static bool table_is_metric(const int32_t *table, size_t labels)
{
    for (size_t a = 0; a < labels; a++) {
        for (size_t b = 0; b < labels; b++) {
            int64_t ab = table[a * labels + b];
            for (size_t c = 0; c < labels; c++) {
                if (table[a * labels + c] > ab + table[b * labels + c]) {
                    return false;
                }
            }
        }
    }
    return true;
}

static bool is_metric(const qs_model *model)
{
    uint32_t truncation = model->pairwise.truncation;
    switch (model->pairwise.smoothness) {
    case QS_POTTS:
    case QS_TRUNCATED_LINEAR: return true;
    /* V(2) <= 2 V(1) where there is a distance of 2; truncated at 1 or 2 it is linear. */
    case QS_TRUNCATED_QUADRATIC: return model->labels <= 2 || truncation == 1 || truncation == 2;
    case QS_TABLE: break;
    }
    return is_semi_metric(model) && table_is_metric(model->pairwise.table, model->labels);
}

/* Expansion. */

typedef struct expansion {
    mover m;
    uint32_t chunks;
    int32_t *height; /* labels x sites */
    int32_t *dual; /* labels x edges; of a grid the edges to the right, then those down */
    int32_t *now; /* height of the present label */
    int32_t *first,
        *second; /* of each edge: y of the present label of its first site, and of its second */
    int32_t *row; /* V(label, .) */
    uint64_t *changed; /* of each chunk: when a label in it or beside it changed last */
    uint32_t *loaded, loaded_count;
    uint16_t label; /* of the present move, and its: */
    int32_t *label_height, *label_dual;
} expansion;

static uint64_t edge_count(const qs_model *model)
{
    return is_grid(model) ? 2 * (uint64_t)model->sites : model->edges;
}

static size_t take_expansion(expansion *e, const qs_model *model, void *workspace)
{
    parts memory = {.base = workspace};
    e->m.model = model;
    e->chunks = model->sites / CHUNK + (model->sites % CHUNK > 0);
    take_mover(&e->m, &memory);
    e->height = part(&memory, (uint64_t)model->sites * model->labels, sizeof *e->height);
    e->dual = part(&memory, edge_count(model), (uint64_t)sizeof *e->dual * model->labels);
    e->now = part(&memory, model->sites, sizeof *e->now);
    e->first = part(&memory, edge_count(model), sizeof *e->first);
    e->second = part(&memory, edge_count(model), sizeof *e->second);
    e->row = part(&memory, model->labels, sizeof *e->row);
    e->changed = part(&memory, e->chunks, sizeof *e->changed);
    e->loaded = part(&memory, e->chunks, sizeof *e->loaded);
    return parts_size(&memory);
}

size_t qs_expansion_workspace(const qs_model *model)
{
    expansion e;
    return take_expansion(&e, model, NULL);
}

static uint32_t chunk_end(const expansion *e, uint32_t chunk)
{
    uint32_t begin = chunk * CHUNK;
    return e->m.model->sites - begin < CHUNK ? e->m.model->sites : begin + CHUNK;
}

/* Half of an edge's cost to each side, where there is one: then its rest is 0. */
static void start_edge(expansion *e, size_t edge, int32_t weight, uint32_t p, uint32_t q)
{
    size_t sites = e->m.model->sites, edges = (size_t)edge_count(e->m.model);
    uint16_t a = e->m.x[p], b = e->m.x[q];
    int32_t cost = (int32_t)(weight * qs_model_pairwise(e->m.model, a, b));
    int32_t near = cost - cost / 2, far = -(cost / 2);
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

static void start_edges(expansion *e)
{
    const qs_model *model = e->m.model;
    for (uint32_t p = 0; is_grid(model) && p < model->sites; p++) {
        if (model->right[p] != 0) {
            start_edge(e, p, model->right[p], p, p + 1);
        }
        if (model->down[p] != 0) {
            start_edge(e, (size_t)model->sites + p, model->down[p], p, p + model->width);
        }
    }
    for (uint32_t p = 0; !is_grid(model) && p < model->sites; p++) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            const qs_link *link = &model->links[n];
            if (link->site > p) {
                start_edge(e, link->edge, link->weight, p, link->site);
            }
        }
    }
}

/* Duals anew from the labelling, everything changed. */
static void start_duals(expansion *e)
{
    const qs_model *model = e->m.model;
    size_t sites = model->sites, labels = model->labels, edges = (size_t)edge_count(model);
    for (size_t p = 0; p < sites; p++) {
        for (size_t a = 0; a < labels; a++) {
            e->height[a * sites + p] = model->unary[p * labels + a];
        }
    }
    memset(e->dual, 0, sizeof *e->dual * edges * labels);
    memset(e->first, 0, sizeof *e->first * edges);
    memset(e->second, 0, sizeof *e->second * edges);
    start_edges(e);
    for (size_t p = 0; p < sites; p++) {
        e->now[p] = e->height[e->m.x[p] * sites + p];
    }
    for (uint32_t c = 0; c < e->chunks; c++) {
        e->changed[c] = e->m.now;
    }
}

/* Edges of a grid, one beside the other: what the three passes over a chunk need of each. The
 * bounds of a dual:
 *
 *     first - weight V(x_p, label) <= dual <= second + weight V(label, x_q) */
typedef struct edge_run {
    uint32_t count;
    const uint16_t *x_p, *x_q;
    const int32_t *weight, *first, *second;
    int32_t *dual, *height_p, *height_q, *out, *in;
} edge_run;

/* Those to the right from sites begin .. end - 1, or those down, as far as there are any. */
static edge_run run_of(const expansion *e, bool down, uint32_t begin, uint32_t end)
{
    const qs_model *model = e->m.model;
    uint32_t step = down ? model->width : 1, last = model->sites - step;
    size_t at = down ? (size_t)model->sites + begin : begin;
    int32_t *residual = e->m.cut.residual + (down ? 2 * (size_t)model->sites : 0) + begin;
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
INLINE int32_t apart(const expansion *e, bool potts, int32_t weight, uint16_t x)
{
    return potts ? (x != e->label ? weight : 0) : weight * e->row[x];
}

/* Puts the duals between their bounds. */
INLINE void settle_run(expansion *e, bool potts, const edge_run *run)
{
    int32_t shift[CHUNK], *restrict dual = run->dual;
    for (uint32_t i = 0; i < run->count; i++) {
        int32_t low = run->first[i] - apart(e, potts, run->weight[i], run->x_p[i]);
        int32_t high = run->second[i] + apart(e, potts, run->weight[i], run->x_q[i]);
        int32_t to = dual[i] > high ? high : dual[i];
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

INLINE void load_run(const expansion *e, bool potts, const edge_run *run)
{
    int32_t *restrict out = run->out, *restrict in = run->in;
    for (uint32_t i = 0; i < run->count; i++) {
        out[i] = run->second[i] + apart(e, potts, run->weight[i], run->x_q[i]) - run->dual[i];
        in[i] = run->dual[i] - run->first[i] + apart(e, potts, run->weight[i], run->x_p[i]);
    }
}

INLINE void store_run(const expansion *e, bool potts, const edge_run *run)
{
    int32_t *restrict dual = run->dual;
    for (uint32_t i = 0; i < run->count; i++) {
        dual[i] = run->second[i] + apart(e, potts, run->weight[i], run->x_q[i]) - run->out[i];
    }
}

typedef enum pass { SETTLE, LOAD, STORE } pass;

INLINE void pass_run(expansion *e, bool potts, pass what, const edge_run *run)
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
    bool potts = e->m.model->pairwise.smoothness == QS_POTTS;
    switch (what) {
    case SETTLE: potts ? pass_run(e, true, SETTLE, &run) : pass_run(e, false, SETTLE, &run); break;
    case LOAD: potts ? pass_run(e, true, LOAD, &run) : pass_run(e, false, LOAD, &run); break;
    case STORE: potts ? pass_run(e, true, STORE, &run) : pass_run(e, false, STORE, &run); break;
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
    if (is_grid(model)) {
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

/* Site p takes the label. */
static void take_label(expansion *e, uint32_t p)
{
    const qs_model *model = e->m.model;
    uint32_t width = model->width;
    e->m.energy += e->label_height[p] - e->now[p];
    e->m.x[p] = e->label;
    e->now[p] = e->label_height[p];
    e->changed[p / CHUNK] = e->m.now;
    if (!is_grid(model)) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            const qs_link *link = &model->links[n];
            *(link->site > p ? &e->first[link->edge] : &e->second[link->edge]) =
                e->label_dual[link->edge];
            e->changed[link->site / CHUNK] = e->m.now;
        }
        return;
    }
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

/* Loads what has changed since the last move to the label, all where that is much; tells of the
 * sources. */
static void find_sources(expansion *e)
{
    uint64_t since = e->m.now - e->m.model->labels;
    uint32_t changed = 0;
    for (uint32_t c = 0; c < e->chunks; c++) {
        if (e->changed[c] > since) {
            pass_chunk(e, SETTLE, c);
            changed++;
        }
    }
    bool all = changed > e->chunks / MUCH;
    for (uint32_t c = 0; c < e->chunks; c++) {
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

/* The best move to the label; whether it lowered the energy. */
static bool expand(expansion *e, uint16_t label)
{
    const qs_model *model = e->m.model;
    int64_t before = e->m.energy;
    e->label = label;
    e->label_height = e->height + (size_t)label * model->sites;
    e->label_dual = e->dual + (size_t)label * (size_t)edge_count(model);
    e->loaded_count = 0;
    for (uint32_t b = 0; b < model->labels; b++) {
        e->row[b] = (int32_t)qs_model_pairwise(model, label, b);
    }
    qs_cut_begin(&e->m.cut);
    find_sources(e);
    qs_cut_run(&e->m.cut);
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

/* Cycles until as many moves as there are labels have failed. */
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
                start_duals(e);
                reached = 2;
            }
            failed = expand(e, (uint16_t)a) ? 0 : failed + 1;
            e->m.now++;
            solution->energy = e->m.energy;
            going = qs_told(options, solution);
        }
    }
    solution->converged = failed >= labels;
    solution->energy = e->m.energy;
}

qs_status qs_expansion(const qs_model *model, const qs_solve_options *options, void *workspace,
                       size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_expansion_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    if (!is_metric(model)) {
        return QS_E_ENCODING;
    }
    int64_t times = times_in_range(model);
    if (times < 4) {
        return QS_E_OVERFLOW;
    }
    expansion e = {.m.x = labelling, .m.now = 2 * (uint64_t)model->labels};
    take_expansion(&e, model, workspace);
    start_mover(&e.m);
    e.m.cut.load = load;
    e.m.cut.context = &e;
    start_duals(&e);
    *solution = (qs_solution){.lower_bound = QS_NO_BOUND};
    expand_all(&e, options, times, solution);
    solution->energy -= qs_local_keep(model, labelling);
    return QS_OK;
}

/* Swap. A move of the pair (a, b) is a cut on the sites that have either: b is the source side. The
 * edges between them are pushed full at first, so that the present labelling costs just what its
 * terminals are cut of: nothing, and no flow is needed. */

typedef struct swapper {
    mover m;
    uint64_t
        *changed; /* of each label: when its sites, or their neighbours' labels, changed last */
    uint32_t *members, member_count;
    uint16_t a, b;
} swapper;

static size_t take_swapper(swapper *s, const qs_model *model, void *workspace)
{
    parts memory = {.base = workspace};
    s->m.model = model;
    take_mover(&s->m, &memory);
    s->changed = part(&memory, model->labels, sizeof *s->changed);
    s->members = part(&memory, model->sites, sizeof *s->members);
    return parts_size(&memory);
}

size_t qs_swap_workspace(const qs_model *model)
{
    swapper s;
    return take_swapper(&s, model, NULL);
}

static void find_members(swapper *s)
{
    const uint16_t *x = s->m.x;
    uint32_t sites = s->m.model->sites;
    s->member_count = 0;
    for (uint32_t begin = 0; begin < sites;) {
        uint32_t end = sites - begin < CHUNK ? sites : begin + CHUNK;
        unsigned any = 0;
        for (uint32_t p = begin; p < end; p++) {
            any |= (unsigned)(x[p] == s->a) | (unsigned)(x[p] == s->b);
        }
        for (; any && begin < end; begin++) {
            s->members[s->member_count] = begin;
            s->member_count += x[begin] == s->a || x[begin] == s->b;
        }
        begin = end;
    }
}

/* The edge from p to q: what it adds to p's excess, and the residual of its arc. */
static int32_t load_swap_arc(const swapper *s, uint32_t p, uint32_t q, int32_t weight,
                             int32_t *residual)
{
    const qs_model *model = s->m.model;
    uint16_t here = s->m.x[p], there = s->m.x[q];
    if (there != s->a && there != s->b) {
        *residual = 0;
        return weight * (int32_t)(qs_model_pairwise(model, s->a, there) -
                                  qs_model_pairwise(model, s->b, there));
    }
    int32_t cost = weight * (int32_t)qs_model_pairwise(model, s->a, s->b);
    *residual = here == there ? cost : here == s->b ? 0 : 2 * cost;
    return here == there ? 0 : here == s->b ? -cost : cost;
}

static void load_member(swapper *s, uint32_t p)
{
    const qs_model *model = s->m.model;
    const int32_t *unary = model->unary + (size_t)p * model->labels;
    uint32_t width = model->width;
    int32_t excess = unary[s->a] - unary[s->b], *residual = s->m.cut.residual;
    for (uint32_t n = is_grid(model) ? 0 : model->link_start[p];
         !is_grid(model) && n < model->link_start[p + 1]; n++) {
        excess += load_swap_arc(s, p, model->links[n].site, model->links[n].weight, &residual[n]);
    }
    if (is_grid(model)) {
        size_t sites = model->sites;
        residual += p;
        excess += model->right[p]
                      ? load_swap_arc(s, p, p + 1, model->right[p], &residual[QS_CUT_RIGHT * sites])
                      : 0;
        excess += model->down[p] ? load_swap_arc(s, p, p + width, model->down[p],
                                                 &residual[QS_CUT_DOWN * sites])
                                 : 0;
        excess += p > 0 && model->right[p - 1] ? load_swap_arc(s, p, p - 1, model->right[p - 1],
                                                               &residual[QS_CUT_LEFT * sites])
                                               : 0;
        excess += p >= width && model->down[p - width]
                      ? load_swap_arc(s, p, p - width, model->down[p - width],
                                      &residual[QS_CUT_UP * sites])
                      : 0;
    }
    s->m.cut.node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
    s->m.cut.excess[p] = excess;
}

/* What the terminals are cut of by the present labelling. */
static int64_t terminal_cost(const swapper *s)
{
    int64_t cost = 0;
    for (uint32_t i = 0; i < s->member_count; i++) {
        uint32_t p = s->members[i];
        int32_t excess = s->m.cut.excess[p];
        cost += s->m.x[p] == s->b ? (excess < 0 ? -(int64_t)excess : 0) : (excess > 0 ? excess : 0);
    }
    return cost;
}

static int64_t total_excess(const swapper *s)
{
    int64_t sum = 0;
    for (uint32_t i = 0; i < s->member_count; i++) {
        int32_t excess = s->m.cut.excess[s->members[i]];
        sum += excess > 0 ? excess : 0;
    }
    return sum;
}

static void touch_neighbours(swapper *s, uint32_t p)
{
    const qs_model *model = s->m.model;
    uint16_t *x = s->m.x;
    uint32_t width = model->width;
    if (!is_grid(model)) {
        for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
            s->changed[x[model->links[n].site]] = s->m.now;
        }
        return;
    }
    s->changed[x[p + 1 < model->sites ? p + 1 : p]] = s->m.now;
    s->changed[x[p > 0 ? p - 1 : p]] = s->m.now;
    s->changed[x[model->sites - p > width ? p + width : p]] = s->m.now;
    s->changed[x[p >= width ? p - width : p]] = s->m.now;
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

/* The best move of the pair; whether it lowered the energy. */
static bool swap(swapper *s, uint16_t a, uint16_t b)
{
    s->a = a;
    s->b = b;
    find_members(s);
    for (uint32_t i = 0; i < s->member_count; i++) {
        load_member(s, s->members[i]);
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
        qs_cut_run(&s->m.cut);
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

/* Cycles until as many moves as there are pairs have failed. */
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
                going = qs_told(options, solution);
            }
        }
    }
    solution->converged = failed >= pairs;
    solution->energy = s->m.energy;
}

qs_status qs_swap(const qs_model *model, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_swap_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    if (!is_semi_metric(model)) {
        return QS_E_ENCODING;
    }
    if (times_in_range(model) < 4) {
        return QS_E_OVERFLOW;
    }
    swapper s = {.m.x = labelling, .m.now = (uint64_t)model->labels * model->labels};
    take_swapper(&s, model, workspace);
    start_mover(&s.m);
    for (uint32_t a = 0; a < model->labels; a++) {
        s.changed[a] = s.m.now;
    }
    *solution = (qs_solution){.lower_bound = QS_NO_BOUND};
    swap_all(&s, options, solution);
    solution->energy -= qs_local_keep(model, labelling);
    return QS_OK;
}
