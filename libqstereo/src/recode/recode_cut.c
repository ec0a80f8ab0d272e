/* The minimum cut of Ishikawa's graph (docs/MATHS.md): a variable for each vertex, 1 on the side of
 * the source; and, in st-cut-arcs, a variable for each arc. */
#include "../base/minmax.h"
#include "recoder.h"

/* Kinds of edges, in the order of the arcs' variables: along a site's chain; from its last vertex
 * to the sink; from the source to its first; between neighbours. */
enum { CHAIN = 1, SINK = 2, SOURCE = 4, NEIGHBOURS = 8, ALL = 15 };

/* Two vertices, u < v, with an arc each way. */
typedef struct cut_edge {
    uint32_t u, v;
    int64_t there, back; /* capacities of u -> v and of v -> u */
    uint64_t number; /* among all edges */
} cut_edge;

typedef void visit_edge(qs_recoder *r, const cut_edge *edge);

/* The first vertex of a site, which has one vertex more than labels. */
static uint32_t first_vertex(const qs_remaining *rest, uint32_t p)
{
    return rest->start[p] + p;
}

static uint32_t source(const qs_remaining *rest)
{
    return (uint32_t)(rest->counts.labels + rest->counts.undecided);
}

static void visit_site(qs_recoder *r, uint32_t p, unsigned kinds, visit_edge *visit)
{
    const qs_remaining *rest = &r->rest;
    uint32_t vertex = first_vertex(rest, p), size = qs_remaining_size(rest, p), s = source(rest);
    const int64_t *cost = rest->cost + rest->start[p];
    int64_t firm =
        (int64_t)(rest->reach[p].most + r->gap); /* keeps the ends of the chain in place */
    uint32_t links = (kinds & CHAIN) != 0 ? size : 0;
    for (uint32_t i = 0; i < links; i++) {
        cut_edge edge = {vertex + i, vertex + i + 1, cost[i], (int64_t)r->gap, vertex + i};
        visit(r, &edge);
    }
    if ((kinds & SINK) != 0) {
        cut_edge edge = {vertex + size, s + 1, cost[size - 1] + firm, 0, vertex + size};
        visit(r, &edge);
    }
    if ((kinds & SOURCE) != 0) {
        cut_edge edge = {vertex, s, 0, cost[0] + firm, (uint64_t)s + p};
        visit(r, &edge);
    }
}

/* The last boundary that the vertex `index` of a site stands for. Boundary d is the one below label
 * d; the last boundary is above all labels. */
static uint32_t boundary(const qs_remaining *rest, uint32_t p, uint32_t index)
{
    return index < qs_remaining_size(rest, p) ? rest->label[rest->start[p] + index]
                                              : rest->model->labels;
}

/* Boundaries for which the same two vertices stand make one edge. `number` is that of the first
 * edge; returns the number of the one behind the last. */
static uint64_t visit_neighbours(qs_recoder *r, const qs_remaining_edge *edge, uint64_t number,
                                 visit_edge *visit)
{
    const qs_remaining *rest = &r->rest;
    uint32_t i = 0, j = 0;
    for (uint32_t from = 0; from <= rest->model->labels;) {
        uint32_t last = boundary(rest, edge->first, i), other = boundary(rest, edge->second, j),
                 to = qs_min_u32(last, other);
        int64_t capacity = edge->weight * (int64_t)(to - from + 1);
        cut_edge arcs = {first_vertex(rest, edge->first) + i, first_vertex(rest, edge->second) + j,
                         capacity, capacity, number++};
        visit(r, &arcs);
        from = to + 1;
        i += last == to;
        j += other == to;
    }
    return number;
}

/* Visits the edges of some kinds. Where all are visited, returns how many there are. */
static uint64_t visit_edges(qs_recoder *r, unsigned kinds, visit_edge *visit)
{
    const qs_remaining *rest = &r->rest;
    uint64_t number = source(rest) + rest->counts.undecided;
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        visit_site(r, p, kinds, visit);
    }
    uint64_t edges = (kinds & NEIGHBOURS) != 0 ? rest->counts.edges : 0;
    for (uint64_t e = 0; e < edges; e++) {
        if (rest->edges[e].weight > 0) {
            number = visit_neighbours(r, &rest->edges[e], number, visit);
        }
    }
    return number;
}

/* ---- A variable a vertex: sum over arcs of capacity * y_u (1 - y_v). ---- */

static void enter_arcs(qs_recoder *r, const cut_edge *edge)
{
    qs_draft_add(&r->draft, &r->draft.linear[edge->u], edge->there);
    qs_draft_add(&r->draft, &r->draft.linear[edge->v], edge->back);
    qs_draft_couple(&r->draft, edge->u, edge->v, 0, -(edge->there + edge->back));
}

/* ---- A variable an arc too: capacity * z, and force [y_u (1 - y_v) - 2 y_u z - 2 (1 - y_v) z + 3
 * z]. ---- */

/* Variables of an edge's two arcs: first all u -> v with u < v, then all v -> u. */
static uint32_t arc_variable(const qs_recoder *r, const cut_edge *edge, bool back)
{
    uint64_t all = (r->draft.variables - source(&r->rest) - 2) / 2;
    return (uint32_t)(source(&r->rest) + 2 + edge->number + (back ? all : 0));
}

static void count_edge(qs_recoder *r, const cut_edge *edge)
{
    r->force = qs_max_i64(r->force, qs_max_i64(edge->there, edge->back));
}

static void enter_linear(qs_recoder *r, const cut_edge *edge)
{
    int64_t *linear = r->draft.linear;
    qs_draft_add(&r->draft, &linear[edge->u], r->force);
    qs_draft_add(&r->draft, &linear[edge->v], r->force);
    qs_draft_add(&r->draft, &linear[arc_variable(r, edge, false)], edge->there + r->force);
    qs_draft_add(&r->draft, &linear[arc_variable(r, edge, true)], edge->back + r->force);
}

static void couple_vertices(qs_recoder *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->u, edge->v, 0, -2 * r->force);
}

static void couple_tail(qs_recoder *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->u, arc_variable(r, edge, false), 0, -2 * r->force);
}

static void couple_back_tail(qs_recoder *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->v, arc_variable(r, edge, true), 0, -2 * r->force);
}

static void couple_head(qs_recoder *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->v, arc_variable(r, edge, false), 0, 2 * r->force);
}

static void couple_back_head(qs_recoder *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->u, arc_variable(r, edge, true), 0, 2 * r->force);
}

/* Visits all edges kind by kind: each kind is regular in itself and makes few runs. Each begins a
 * run of its own. */
static void by_kind(qs_recoder *r, visit_edge *visit)
{
    static const unsigned kinds[3] = {CHAIN, SINK | SOURCE, NEIGHBOURS};
    for (int k = 0; k < 3; k++) {
        size_t from = r->draft.pair_count;
        visit_edges(r, kinds[k], visit);
        if (r->draft.pair_count > from) {
            r->draft.pairs[from].block |= QS_NEW_RUN;
        }
    }
}

static void enter_all_arcs(qs_recoder *r)
{
    uint32_t vertices = source(&r->rest) + 2;
    r->force = 0;
    uint64_t edges = visit_edges(r, ALL, count_edge);
    r->force += (int64_t)r->gap;
    qs_draft_groups(&r->draft, (uint32_t)(vertices + 2 * edges), 1, 0, 0);
    visit_edges(r, ALL, enter_linear);
    by_kind(r, couple_vertices);
    by_kind(r, couple_tail);
    by_kind(r, couple_back_tail);
    by_kind(r, couple_head);
    by_kind(r, couple_back_head);
}

void qs_recode_cut(qs_recoder *r)
{
    uint32_t s = source(&r->rest);
    qs_add_block(r, (qs_block_of){QS_SCALAR_BLOCK, 0, 0, 0});
    if (r->encoding == QS_ST_CUT) {
        qs_draft_groups(&r->draft, s + 2, 1, 0, 0);
        by_kind(r, enter_arcs);
    } else {
        enter_all_arcs(r);
    }
    int64_t bound = (int64_t)(qs_winner_energy(&r->rest) + r->gap); /* above the least cut */
    qs_draft_add(&r->draft, &r->draft.offset, bound);
    qs_draft_add(&r->draft, &r->draft.linear[s], -bound);
    qs_draft_add(&r->draft, &r->draft.linear[s + 1], bound);
}
