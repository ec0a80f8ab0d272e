/* The minimum cuts of Ishikawa's graph (docs/MATHS.md): a variable a vertex, 1 on the side of the
 * source; and, for st-cut-arcs, a variable an arc. */
#include "../base/saturate.h"
#include "recoding.h"

/* Kinds of edges, in the order of the arcs' variables: along a site's chain; from its last vertex
 * to the sink; from the source to its first; between neighbours. */
enum { CHAIN = 1, SINK = 2, SOURCE = 4, NEIGHBOURS = 8, ALL = 15 };

/* Two vertices, u < v, with an arc each way. */
typedef struct cut_edge {
    uint32_t u, v;
    int64_t there, back; /* capacities of u -> v and of v -> u */
    uint64_t number; /* among all edges */
} cut_edge;

typedef void visit_edge(qs_recoding *r, const cut_edge *edge);

/* First vertex of a site, which has one more than labels. */
static uint32_t first_vertex(const qs_left *left, uint32_t p)
{
    return left->start[p] + p;
}

static uint32_t source(const qs_left *left)
{
    return (uint32_t)(left->counts.labels + left->counts.open);
}

static void visit_site(qs_recoding *r, uint32_t p, unsigned kinds, visit_edge *visit)
{
    const qs_left *left = &r->left;
    uint32_t vertex = first_vertex(left, p), size = qs_left_size(left, p), s = source(left);
    const int64_t *cost = left->cost + left->start[p];
    int64_t firm =
        (int64_t)(left->reach[p].most + r->gap); /* keeps the ends of the chain in place */
    for (uint32_t i = 0; (kinds & CHAIN) != 0 && i < size; i++) {
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

/* The last boundary between labels, from 0, that the vertex `index` of a site stands for: below the
 * label itself, or above all. */
static uint32_t boundary(const qs_left *left, uint32_t p, uint32_t index)
{
    return index < qs_left_size(left, p) ? left->label[left->start[p] + index]
                                         : left->model->labels;
}

/* Boundaries where the same two vertices stand for both sites make one edge; returns the number of
 * the next. */
static uint64_t visit_neighbours(qs_recoding *r, const qs_edge *edge, uint64_t number,
                                 visit_edge *visit)
{
    const qs_left *left = &r->left;
    uint32_t i = 0, j = 0;
    for (uint32_t from = 0; from <= left->model->labels;) {
        uint32_t last = boundary(left, edge->first, i), other = boundary(left, edge->second, j),
                 to = last < other ? last : other;
        int64_t capacity = edge->weight * (int64_t)(to - from + 1);
        cut_edge arcs = {first_vertex(left, edge->first) + i, first_vertex(left, edge->second) + j,
                         capacity, capacity, number++};
        visit(r, &arcs);
        from = to + 1;
        i += last == to;
        j += other == to;
    }
    return number;
}

/* Visits the edges of some kinds; returns the number of all edges, if all are visited. */
static uint64_t visit_edges(qs_recoding *r, unsigned kinds, visit_edge *visit)
{
    const qs_left *left = &r->left;
    uint64_t number = source(left) + left->counts.open;
    for (uint32_t p = 0; p < left->counts.open; p++) {
        visit_site(r, p, kinds, visit);
    }
    for (uint64_t e = 0; (kinds & NEIGHBOURS) != 0 && e < left->counts.edges; e++) {
        if (left->edges[e].weight > 0) {
            number = visit_neighbours(r, &left->edges[e], number, visit);
        }
    }
    return number;
}

/* ---- A variable a vertex: sum over arcs of capacity * y_u (1 - y_v). ---- */

static void enter_arcs(qs_recoding *r, const cut_edge *edge)
{
    qs_draft_add(&r->draft, &r->draft.linear[edge->u], edge->there);
    qs_draft_add(&r->draft, &r->draft.linear[edge->v], edge->back);
    qs_draft_couple(&r->draft, edge->u, edge->v, 0, -(edge->there + edge->back));
}

/* ---- A variable an arc too: capacity * z, and force [y_u (1 - y_v) - 2 y_u z - 2 (1 - y_v) z + 3
 * z]. ---- */

/* Variables of an edge's two arcs: first all u -> v with u < v, then all v -> u. */
static uint32_t arc_variable(const qs_recoding *r, const cut_edge *edge, bool back)
{
    uint64_t all = (r->draft.variables - source(&r->left) - 2) / 2;
    return (uint32_t)(source(&r->left) + 2 + edge->number + (back ? all : 0));
}

static void count_edge(qs_recoding *r, const cut_edge *edge)
{
    int64_t larger = edge->there > edge->back ? edge->there : edge->back;
    r->force = larger > r->force ? larger : r->force;
}

static void enter_linear(qs_recoding *r, const cut_edge *edge)
{
    int64_t *linear = r->draft.linear;
    qs_draft_add(&r->draft, &linear[edge->u], r->force);
    qs_draft_add(&r->draft, &linear[edge->v], r->force);
    qs_draft_add(&r->draft, &linear[arc_variable(r, edge, false)], edge->there + r->force);
    qs_draft_add(&r->draft, &linear[arc_variable(r, edge, true)], edge->back + r->force);
}

static void couple_vertices(qs_recoding *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->u, edge->v, 0, -2 * r->force);
}

static void couple_tail(qs_recoding *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->u, arc_variable(r, edge, false), 0, -2 * r->force);
}

static void couple_back_tail(qs_recoding *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->v, arc_variable(r, edge, true), 0, -2 * r->force);
}

static void couple_head(qs_recoding *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->v, arc_variable(r, edge, false), 0, 2 * r->force);
}

static void couple_back_head(qs_recoding *r, const cut_edge *edge)
{
    qs_draft_couple(&r->draft, edge->u, arc_variable(r, edge, true), 0, 2 * r->force);
}

/* Visits all edges kind by kind, as each is regular in itself; what comes is not a part of the run
 * before. */
static void by_kind(qs_recoding *r, visit_edge *visit)
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

static void enter_all_arcs(qs_recoding *r)
{
    uint32_t vertices = source(&r->left) + 2;
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

void qs_recode_cut(qs_recoding *r)
{
    uint32_t s = source(&r->left);
    qs_add_block(r, (qs_block_of){QS_SCALAR_BLOCK, 0, 0});
    if (r->encoding == QS_ST_CUT) {
        qs_draft_groups(&r->draft, s + 2, 1, 0, 0);
        by_kind(r, enter_arcs);
    } else {
        enter_all_arcs(r);
    }
    int64_t bound = (int64_t)(qs_winner_energy(&r->left) + r->gap); /* above the least cut */
    qs_draft_add(&r->draft, &r->draft.offset, bound);
    qs_draft_add(&r->draft, &r->draft.linear[s], -bound);
    qs_draft_add(&r->draft, &r->draft.linear[s + 1], bound);
}
