/* The blocks of two sites depend on their label sets alone: one for each two sets that meet. */
#include <string.h>

#include "../encode/penalty.h"
#include "../base/saturate.h"
#include "../problem/pairwise.h"
#include "recoding.h"
#include "../base/sort.h"

/* ---- Entries. ---- */

static uint32_t label_of(const qs_left *left, uint32_t site, uint32_t index)
{
    return left->label[left->start[site] + index];
}

/* Of variables u_row+1 and u_column+1 of two domain walls: x_i = u_i - u_i+1 in sum_ij V(i, j) x_i
 * x_j. */
static int64_t wall_entry(const qs_left *left, const qs_block_of *block, uint32_t row,
                          uint32_t column)
{
    const qs_model *m = left->model;
    uint32_t a = label_of(left, block->first, row), b = label_of(left, block->first, row + 1);
    uint32_t c = label_of(left, block->second, column),
             d = label_of(left, block->second, column + 1);
    return qs_model_pairwise(m, b, d) - qs_model_pairwise(m, a, d) - qs_model_pairwise(m, b, c) +
           qs_model_pairwise(m, a, c);
}

static int64_t pair_entry(const qs_recoding *r, const qs_block_of *block, uint32_t row,
                          uint32_t column)
{
    const qs_left *left = &r->left;
    const qs_model *m = left->model;
    if (r->encoding == QS_DOMAIN_WALL) {
        return wall_entry(left, block, row, column);
    }
    uint32_t a = label_of(left, block->first, row), b = label_of(left, block->second, column);
    return r->encoding == QS_ONE_HOT_SPARSE
               ? -qs_band_entry(qs_band(&m->pairwise, m->labels), (int64_t)a - b)
               : qs_model_pairwise(m, a, b);
}

static int64_t entry(const void *context, uint32_t number, uint32_t row, uint32_t column)
{
    const qs_recoding *r = context;
    const qs_block_of *block = &r->blocks[number];
    switch (block->kind) {
    case QS_PAIR_BLOCK: return pair_entry(r, block, row, column);
    case QS_CHAIN_BLOCK: return -(int64_t)(column == row + 1);
    case QS_TERMINAL_BLOCK: return label_of(&r->left, block->first, row) != column;
    case QS_SCALAR_BLOCK: break;
    }
    return 1;
}

static qs_block_shape shape(const void *context, uint32_t number)
{
    const qs_recoding *r = context;
    const qs_left *left = &r->left;
    const qs_block_of *block = &r->blocks[number];
    bool wall = r->encoding == QS_DOMAIN_WALL;
    qs_block_shape s = {1, 1, true, 0};
    if (block->kind == QS_SCALAR_BLOCK) {
        return s;
    }
    s.rows = qs_left_size(left, block->first) - wall;
    s.columns = block->kind == QS_TERMINAL_BLOCK ? left->model->labels
                                                 : qs_left_size(left, block->second) - wall;
    s.toeplitz = block->kind == QS_CHAIN_BLOCK || qs_left_is_range(left, block->first);
    if (block->kind == QS_PAIR_BLOCK) {
        s.toeplitz &=
            qs_left_is_range(left, block->second) && left->model->pairwise.smoothness != QS_TABLE;
    }
    bool dense = r->encoding == QS_ONE_HOT || r->encoding == QS_MULTIWAY_CUT;
    s.fill = dense && s.columns > 1 ? entry(context, number, 0, s.columns - 1) : 0;
    return s;
}

uint32_t qs_add_block(qs_recoding *r, qs_block_of block)
{
    r->draft.shape = shape;
    r->draft.entry = entry;
    r->draft.blocks = r;
    r->blocks[r->draft.block_count] = block;
    return r->draft.block_count++;
}

/* ---- Sets. ---- */

/* Shorter sets first. */
static int compare_sets(const qs_left *left, uint32_t a, uint32_t b)
{
    uint32_t size_a = qs_left_size(left, a), size_b = qs_left_size(left, b);
    if (size_a != size_b) {
        return size_a < size_b ? -1 : 1;
    }
    return memcmp(left->label + left->start[a], left->label + left->start[b],
                  size_a * sizeof *left->label);
}

static bool set_before(const void *context, uint32_t a, uint32_t b)
{
    return compare_sets(context, a, b) < 0;
}

void qs_number_sets(qs_recoding *r)
{
    uint32_t open = (uint32_t)r->left.counts.open, sets = 0;
    for (uint32_t p = 0; p < open; p++) {
        r->order[p] = p;
    }
    qs_sort(r->order, r->scratch, open, set_before, &r->left);
    for (uint32_t i = 0; i < open; i++) {
        sets += i > 0 && compare_sets(&r->left, r->order[i - 1], r->order[i]) != 0;
        r->set[r->order[i]] = sets;
    }
}

/* ---- Pairs of neighbours. ---- */

static bool edge_before(const void *context, uint32_t a, uint32_t b)
{
    const qs_recoding *r = context;
    const qs_edge *x = &r->left.edges[a], *y = &r->left.edges[b];
    uint32_t first = r->set[x->first], other = r->set[y->first];
    return first != other ? first < other : r->set[x->second] < r->set[y->second];
}

/* In one-hot files of a whole masked grid each run is a row's own (docs/FORMAT.md). */
static bool ends_run(const qs_recoding *r, const qs_edge *before, const qs_edge *edge)
{
    const qs_left *left = &r->left;
    const qs_model *m = left->model;
    if (!m->mask || !left->counts.whole || r->encoding > QS_ONE_HOT_SPARSE) {
        return false;
    }
    uint32_t from = left->cell[before->first], to = left->cell[before->second];
    bool same_row = (from + 1) % m->width != 0;
    return !(same_row && left->cell[edge->first] == from + 1 && left->cell[edge->second] == to + 1);
}

static void couple_set_pair(qs_recoding *r, const uint32_t *edges, size_t count)
{
    const qs_left *left = &r->left;
    const qs_edge *one = &left->edges[edges[0]];
    uint32_t block = qs_add_block(r, (qs_block_of){QS_PAIR_BLOCK, one->first, one->second});
    /* Repair moves the walls of linear costs along every edge, also where no two labels left tell
     * the edge's cost from unary ones. */
    bool wanted = left->counts.whole || (r->encoding == QS_DOMAIN_WALL &&
                                         qs_is_linear(&left->model->pairwise, left->model->labels));
    if (!wanted && qs_draft_block_sum(&r->draft, block) == 0) {
        r->draft.block_count--; /* what the edges cost is in the offset and the linear terms */
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const qs_edge *edge = &left->edges[edges[i]];
        bool ends = i > 0 && ends_run(r, &left->edges[edges[i - 1]], edge);
        qs_draft_couple(&r->draft, edge->first, edge->second, block | (ends ? QS_NEW_RUN : 0),
                        edge->weight);
    }
}

void qs_couple_neighbours(qs_recoding *r)
{
    size_t count = (size_t)r->left.counts.edges;
    for (size_t e = 0; e < count; e++) {
        r->order[e] = (uint32_t)e;
    }
    qs_sort(r->order, r->scratch, count, edge_before, r);
    for (size_t from = 0, to; from < count; from = to) {
        for (to = from + 1; to < count && !edge_before(r, r->order[from], r->order[to]); to++) {
        }
        couple_set_pair(r, r->order + from, to - from);
    }
}

uint64_t qs_winner_energy(const qs_left *left)
{
    uint64_t energy = 0;
    for (uint64_t e = 0; e < left->counts.edges; e++) {
        const qs_edge *edge = &left->edges[e];
        uint32_t label[2];
        for (int side = 0; side < 2; side++) {
            uint32_t i = left->start[side == 0 ? edge->first : edge->second];
            while (left->cost[i] != 0) {
                i++;
            }
            label[side] = left->label[i];
        }
        qs_grow(&energy, (uint64_t)edge->weight,
                (uint64_t)qs_model_pairwise(left->model, label[0], label[1]));
    }
    return energy;
}
