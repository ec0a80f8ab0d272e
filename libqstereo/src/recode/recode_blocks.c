/* Where all edges share V the block of two sites depends on their label sets alone. So there is one
 * block for each two sets of which two sites are neighbours. */
#include <string.h>

#include "../base/saturate.h"
#include "../base/sort.h"
#include "../model/edge_value.h"
#include "../problem/pairwise.h"
#include "recoder.h"

/* ---- Entries. ---- */

/* The label of a site that has `index` labels left below it. */
static uint32_t label_of(const qs_remaining *rest, uint32_t site, uint32_t index)
{
    return rest->label[rest->start[site] + index];
}

/* Of the variables u_row+1 and u_column+1 of two domain walls: put x_i = u_i - u_i+1 into
 * sum_ij V(i, j) x_i x_j. */
static int64_t wall_entry(const qs_remaining *rest, const qs_block_of *block, uint32_t row,
                          uint32_t column)
{
    const qs_model *m = rest->model;
    uint32_t a = label_of(rest, block->first, row), b = label_of(rest, block->first, row + 1);
    uint32_t c = label_of(rest, block->second, column),
             d = label_of(rest, block->second, column + 1), edge = block->edge;
    return qs_edge_value(m, edge, b, d) - qs_edge_value(m, edge, a, d) -
           qs_edge_value(m, edge, b, c) + qs_edge_value(m, edge, a, c);
}

static int64_t pair_entry(const qs_recoder *r, const qs_block_of *block, uint32_t row,
                          uint32_t column)
{
    const qs_remaining *rest = &r->rest;
    const qs_model *m = rest->model;
    if (r->encoding == QS_DOMAIN_WALL) {
        return wall_entry(rest, block, row, column);
    }
    uint32_t a = label_of(rest, block->first, row), b = label_of(rest, block->second, column);
    if (r->encoding == QS_ONE_HOT_SPARSE) {
        return -qs_band_entry(qs_band(&m->pairwise, m->labels), (int64_t)a - b);
    }
    return qs_edge_value(m, block->edge, a, b);
}

static int64_t entry(const void *context, uint32_t number, uint32_t row, uint32_t column)
{
    const qs_recoder *r = context;
    const qs_block_of *block = &r->blocks[number];
    switch (block->kind) {
    case QS_PAIR_BLOCK: return pair_entry(r, block, row, column);
    case QS_CHAIN_BLOCK: return -(int64_t)(column == row + 1);
    case QS_TERMINAL_BLOCK: return label_of(&r->rest, block->first, row) != column;
    case QS_SCALAR_BLOCK: break;
    }
    return 1;
}

static qs_block_shape shape(const void *context, uint32_t number)
{
    const qs_recoder *r = context;
    const qs_remaining *rest = &r->rest;
    const qs_block_of *block = &r->blocks[number];
    bool wall = r->encoding == QS_DOMAIN_WALL;
    qs_block_shape s = {1, 1, true, 0};
    if (block->kind == QS_SCALAR_BLOCK) {
        return s;
    }
    s.rows = qs_remaining_size(rest, block->first) - wall;
    s.columns = block->kind == QS_TERMINAL_BLOCK ? rest->model->labels
                                                 : qs_remaining_size(rest, block->second) - wall;
    s.toeplitz = block->kind == QS_CHAIN_BLOCK || qs_remaining_is_range(rest, block->first);
    if (block->kind == QS_PAIR_BLOCK) {
        s.toeplitz &= qs_remaining_is_range(rest, block->second) &&
                      rest->model->pairwise.smoothness < QS_TABLE;
    }
    bool dense = r->encoding == QS_ONE_HOT || r->encoding == QS_MULTIWAY_CUT;
    s.fill = dense && s.columns > 1 ? entry(context, number, 0, s.columns - 1) : 0;
    return s;
}

uint32_t qs_add_block(qs_recoder *r, qs_block_of block)
{
    r->draft.shape = shape;
    r->draft.entry = entry;
    r->draft.blocks = r;
    r->blocks[r->draft.block_count] = block;
    return r->draft.block_count++;
}

/* ---- Sets. ---- */

/* Shorter sets first. */
static int compare_sets(const qs_remaining *rest, uint32_t a, uint32_t b)
{
    uint32_t size_a = qs_remaining_size(rest, a), size_b = qs_remaining_size(rest, b);
    if (size_a != size_b) {
        return size_a < size_b ? -1 : 1;
    }
    return memcmp(rest->label + rest->start[a], rest->label + rest->start[b],
                  size_a * sizeof *rest->label);
}

static bool set_before(const void *context, uint32_t a, uint32_t b)
{
    return compare_sets(context, a, b) < 0;
}

void qs_number_sets(qs_recoder *r)
{
    uint32_t sites = (uint32_t)r->rest.counts.undecided, sets = 0;
    for (uint32_t p = 0; p < sites; p++) {
        r->order[p] = p;
    }
    qs_sort(r->order, r->scratch, sites, set_before, &r->rest);
    for (uint32_t i = 0; i < sites; i++) {
        sets += i > 0 && compare_sets(&r->rest, r->order[i - 1], r->order[i]) != 0;
        r->set[r->order[i]] = sets;
    }
}

/* ---- Pairs of neighbours. ---- */

static bool edge_before(const void *context, uint32_t a, uint32_t b)
{
    const qs_recoder *r = context;
    const qs_remaining_edge *x = &r->rest.edges[a], *y = &r->rest.edges[b];
    uint32_t first = r->set[x->first], other = r->set[y->first];
    return first != other ? first < other : r->set[x->second] < r->set[y->second];
}

/* In one-hot files of a whole grid that is masked, or whose edges have tables of their own, no run
 * goes on from one row into the next, nor over a masked cell (docs/FORMAT.md). */
static bool ends_run(const qs_recoder *r, const qs_remaining_edge *before,
                     const qs_remaining_edge *edge)
{
    const qs_remaining *rest = &r->rest;
    const qs_model *m = rest->model;
    bool by_rows = m->width > 0 && (m->mask || m->tables);
    if (!by_rows || !rest->counts.whole || !qs_encoding_facts_of(r->encoding)->is_streamed) {
        return false;
    }
    uint32_t from = rest->cell[before->first], to = rest->cell[before->second];
    bool same_row = (from + 1) % m->width != 0;
    return !(same_row && rest->cell[edge->first] == from + 1 && rest->cell[edge->second] == to + 1);
}

static void couple_set_pair(qs_recoder *r, const uint32_t *edges, size_t count)
{
    const qs_remaining *rest = &r->rest;
    const qs_remaining_edge *one = &rest->edges[edges[0]];
    uint32_t block =
        qs_add_block(r, (qs_block_of){QS_PAIR_BLOCK, one->first, one->second, one->edge});
    /* The repair of linear walls needs a coupling for each edge, also where its block is all 0. */
    bool linear_walls =
        r->encoding == QS_DOMAIN_WALL && qs_is_linear(&rest->model->pairwise, rest->model->labels);
    bool wanted = rest->counts.whole || linear_walls;
    if (!wanted && qs_draft_block_sum(&r->draft, block) == 0) {
        r->draft.block_count--; /* what the edges cost is in the offset and the linear terms */
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const qs_remaining_edge *edge = &rest->edges[edges[i]];
        bool ends = i > 0 && ends_run(r, &rest->edges[edges[i - 1]], edge);
        qs_draft_couple(&r->draft, edge->first, edge->second, block | (ends ? QS_NEW_RUN : 0),
                        edge->weight);
    }
}

bool qs_edges_are_like(const qs_recoder *r, const qs_remaining_edge *x, const qs_remaining_edge *y)
{
    const qs_remaining *rest = &r->rest;
    if (r->set[x->first] != r->set[y->first] || r->set[x->second] != r->set[y->second]) {
        return false;
    }
    if (!rest->model->tables) {
        return true;
    }
    uint32_t rows = qs_remaining_size(rest, x->first), columns = qs_remaining_size(rest, x->second);
    for (uint32_t i = 0; i < rows; i++) {
        for (uint32_t j = 0; j < columns; j++) {
            uint32_t a = label_of(rest, x->first, i), b = label_of(rest, x->second, j);
            if (qs_edge_value(rest->model, x->edge, a, b) !=
                qs_edge_value(rest->model, y->edge, a, b)) {
                return false;
            }
        }
    }
    return true;
}

/* Edges with tables of their own, in their order, without those that cost nothing; one after
 * another that are alike share a block. */
static void couple_by_tables(qs_recoder *r)
{
    const qs_remaining_edge *last = NULL;
    uint32_t block = 0;
    for (uint64_t e = 0; e < r->rest.counts.edges; e++) {
        const qs_remaining_edge *edge = &r->rest.edges[e];
        bool alike = last && qs_edges_are_like(r, last, edge);
        if (edge->weight == 0) {
            continue;
        }
        if (!alike) {
            block = qs_add_block(
                r, (qs_block_of){QS_PAIR_BLOCK, edge->first, edge->second, edge->edge});
            if (qs_draft_block_sum(&r->draft, block) == 0) {
                r->draft.block_count--;
                block -= last != NULL;
                continue;
            }
        }
        bool ends = alike && ends_run(r, last, edge);
        qs_draft_couple(&r->draft, edge->first, edge->second, block | (ends ? QS_NEW_RUN : 0),
                        edge->weight);
        last = edge;
    }
}

void qs_order_edges(qs_recoder *r)
{
    size_t count = (size_t)r->rest.counts.edges;
    for (size_t e = 0; e < count; e++) {
        r->order[e] = (uint32_t)e;
    }
    qs_sort(r->order, r->scratch, count, edge_before, r);
}

void qs_couple_neighbours(qs_recoder *r)
{
    if (r->rest.model->tables) {
        couple_by_tables(r);
        return;
    }
    size_t count = (size_t)r->rest.counts.edges;
    qs_order_edges(r);
    for (size_t from = 0; from < count;) {
        size_t to = from + 1;
        while (to < count && !edge_before(r, r->order[from], r->order[to])) {
            to++;
        }
        couple_set_pair(r, r->order + from, to - from);
        from = to;
    }
}

/* The cheapest label of a site: its cost is 0. */
static uint32_t winner(const qs_remaining *rest, uint32_t site)
{
    uint32_t i = rest->start[site];
    while (rest->cost[i] != 0) {
        i++;
    }
    return rest->label[i];
}

uint64_t qs_winner_energy(const qs_remaining *rest)
{
    uint64_t energy = 0;
    for (uint64_t e = 0; e < rest->counts.edges; e++) {
        const qs_remaining_edge *edge = &rest->edges[e];
        int64_t cost = qs_edge_value(rest->model, edge->edge, winner(rest, edge->first),
                                     winner(rest, edge->second));
        qs_grow(&energy, (uint64_t)edge->weight, (uint64_t)cost);
    }
    return energy;
}
