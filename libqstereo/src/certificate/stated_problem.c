#include "stated_problem.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../qubo/blocks.h"
#include "../qubo/qcf_runs.h"
#include "../qubo/sites.h"

static bool has_walls(const qs_qubo *qubo)
{
    return qubo->labels.encoding == QS_DOMAIN_WALL;
}

bool qs_stated_takes(const qs_qubo *qubo)
{
    const qs_encoding_facts *facts =
        qubo->has_labels ? qs_encoding_facts_of(qubo->labels.encoding) : NULL;
    return facts && facts->has_model;
}

/* Calls `found` for every coupling of two groups whose weight is not 0. */
typedef void qs_coupling_found(qs_stated *stated, uint32_t g, uint32_t h, uint32_t block,
                               int32_t weight);

static void each_coupling(qs_stated *stated, qs_coupling_found *found)
{
    const qs_qubo *qubo = stated->index->qubo;
    const uint8_t *at = qubo->coupling_runs;
    for (uint32_t i = 0; i < qubo->coupling_run_count; i++) {
        qs_run_view run = qs_run_at(at);
        for (uint32_t r = 0; r < run.head.repeat; r++) {
            for (uint32_t c = 0; c < run.head.count; c++) {
                uint32_t g, h;
                int32_t weight = qs_run_weight(&run, r, c);
                qs_run_pair(&run, r, c, &g, &h);
                if (weight != 0) {
                    found(stated, g, h, run.head.block, weight);
                }
            }
        }
        at += run.size;
    }
}

/* Rows or columns of a table, for so many rows or columns of its block. */
static size_t table_side(const qs_qubo *qubo, uint32_t variables)
{
    return (size_t)variables + has_walls(qubo);
}

static const uint8_t *block_of(const qs_stated *stated, uint32_t block)
{
    return stated->index->qubo->blocks + stated->index->block_at[block];
}

static uint64_t table_numbers(const qs_index *index)
{
    uint64_t numbers = 0;
    for (uint32_t i = 0; i < index->qubo->block_count; i++) {
        const uint8_t *block = index->qubo->blocks + index->block_at[i];
        numbers += (uint64_t)table_side(index->qubo, qs_block_rows(block)) *
                   table_side(index->qubo, qs_block_columns(block));
    }
    return numbers;
}

void qs_stated_take(qs_stated *stated, const qs_index *index, qs_arena *arena)
{
    const qs_qubo *qubo = index->qubo;
    uint64_t sites = qubo->groups, labels = qubo->variables + (has_walls(qubo) ? sites : 0);
    *stated = (qs_stated){.index = index, .sites = qubo->groups};
    stated->count = qs_arena_take(arena, sites, sizeof *stated->count);
    stated->start = qs_arena_take(arena, sites + 1, sizeof *stated->start);
    stated->unary = qs_arena_take(arena, labels, sizeof *stated->unary);
    stated->kept = qs_arena_take(arena, labels, sizeof *stated->kept);
    stated->left = qs_arena_take(arena, sites, sizeof *stated->left);
    stated->fixed = qs_arena_take(arena, sites, sizeof *stated->fixed);
    stated->settled = qs_arena_take(arena, sites, sizeof *stated->settled);
    stated->edges = qs_arena_take(arena, qubo->couplings, sizeof *stated->edges);
    stated->near_start = qs_arena_take(arena, sites + 1, sizeof *stated->near_start);
    stated->near = qs_arena_take(arena, qubo->couplings, 2 * sizeof *stated->near);
    stated->table_at = qs_arena_take(arena, qubo->block_count, sizeof *stated->table_at);
    stated->tables = qs_arena_take(arena, table_numbers(index), sizeof *stated->tables);
}

/* A block of a domain wall is of variables; labels a and b have the first a and b of them at 1. */
static void sum_table(int64_t *table, size_t rows, size_t columns)
{
    for (size_t i = 1; i < rows; i++) {
        for (size_t j = 1; j < columns; j++) {
            table[i * columns + j] += table[(i - 1) * columns + j] + table[i * columns + j - 1] -
                                      table[(i - 1) * columns + j - 1];
        }
    }
}

static void read_tables(qs_stated *stated, size_t *table_at, int64_t *tables)
{
    const qs_qubo *qubo = stated->index->qubo;
    size_t next = 0, skip = has_walls(qubo);
    for (uint32_t n = 0; n < qubo->block_count; n++) {
        const uint8_t *block = block_of(stated, n);
        size_t rows = table_side(qubo, qs_block_rows(block)),
               columns = table_side(qubo, qs_block_columns(block));
        int64_t *table = tables + next;
        memset(table, 0, sizeof *table * rows * columns);
        for (size_t i = skip; i < rows; i++) {
            for (size_t j = skip; j < columns; j++) {
                table[i * columns + j] =
                    qs_block_entry(block, (uint32_t)(i - skip), (uint32_t)(j - skip));
            }
        }
        if (skip) {
            sum_table(table, rows, columns);
        }
        table_at[n] = next;
        next += rows * columns;
    }
}

/* The largest absolute value in the table of a block, times a weight, is in the bound of the format
 * on all numbers: no product or sum below overflows. */
static void add_edge(qs_stated *stated, uint32_t g, uint32_t h, uint32_t block, int32_t weight)
{
    if (g != h) {
        stated->edges[stated->edge_count++] = (qs_stated_edge){g, h, block, weight, true};
        return;
    }
    /* The chain of a wall: each pair of variables at 1. */
    const uint8_t *table = block_of(stated, block);
    int64_t sum = 0;
    for (uint32_t label = 1; label < stated->count[g]; label++) {
        for (uint32_t i = 0; i + 1 < label; i++) {
            sum += (int64_t)weight * qs_block_entry(table, i, label - 1);
        }
        stated->unary[qs_stated_at(stated, g, label)] += sum;
    }
}

static void read_sites(qs_stated *stated, uint32_t *count, size_t *start)
{
    const qs_index *index = stated->index;
    const qs_labels *l = &index->qubo->labels;
    const uint8_t *trimmed = l->trimmed;
    size_t walls = has_walls(index->qubo), next = 0;
    for (uint32_t p = 0; p < stated->sites; p++) {
        uint32_t variables = index->start[p + 1] - index->start[p];
        count[p] = variables + (uint32_t)walls;
        start[p] = next;
        stated->most_labels = qs_max_u32(stated->most_labels, count[p]);
        int64_t sum = 0, none, pair; /* what a group costs that has none, or a pair, at 1 */
        qs_index_penalty(index, p, &none, &pair);
        for (uint32_t a = 0; a < count[p]; a++, next++) {
            int64_t at_one = walls ? a : 1;
            if (!walls || a > 0) {
                int64_t linear = qs_qubo_linear(index->qubo, index->start[p] + a - (uint32_t)walls);
                sum = walls ? sum + linear : linear;
            }
            stated->unary[next] = sum + none * (1 - at_one) + pair * (at_one * (at_one - 1) / 2);
            if (trimmed) {
                stated->unary[next] += (int64_t)qs_load_unsigned(trimmed, l->trimmed_bytes);
                trimmed += l->trimmed_bytes;
            }
        }
    }
    start[stated->sites] = next;
}

/* Lists the edges of each site. */
static void list_near(const qs_stated *stated, uint32_t *near_start, uint32_t *near)
{
    memset(near_start, 0, sizeof *near_start * (stated->sites + (size_t)1));
    for (uint32_t e = 0; e < stated->edge_count; e++) {
        near_start[stated->edges[e].first]++;
        near_start[stated->edges[e].second]++;
    }
    uint32_t total = 0;
    for (uint32_t p = 0; p <= stated->sites; p++) {
        uint32_t count = near_start[p];
        near_start[p] = total;
        total += p < stated->sites ? count : 0;
    }
    for (uint32_t e = 0; e < stated->edge_count; e++) {
        near[near_start[stated->edges[e].first]++] = e;
        near[near_start[stated->edges[e].second]++] = e;
    }
    memmove(near_start + 1, near_start, sizeof *near_start * stated->sites);
    near_start[0] = 0;
}

/* What all costs come to at most, in absolute value. */
static uint64_t find_magnitude(const qs_stated *stated)
{
    uint64_t all = qs_absolute(stated->constant);
    for (uint32_t p = 0; p < stated->sites; p++) {
        uint64_t largest = 0;
        for (size_t at = stated->start[p]; at < stated->start[p + 1]; at++) {
            largest = qs_max_u64(largest, qs_absolute(stated->unary[at]));
        }
        qs_grow(&all, largest, 1);
    }
    uint32_t block = UINT32_MAX;
    uint64_t largest = 0;
    for (uint32_t e = 0; e < stated->edge_count; e++) {
        const qs_stated_edge *edge = &stated->edges[e];
        if (edge->block != block) {
            size_t numbers = (size_t)stated->count[edge->first] * stated->count[edge->second];
            const int64_t *table = qs_stated_table(stated, edge);
            block = edge->block;
            largest = 0;
            for (size_t i = 0; i < numbers; i++) {
                largest = qs_max_u64(largest, qs_absolute(table[i]));
            }
        }
        qs_grow(&all, largest, qs_absolute(edge->weight));
    }
    return all;
}

void qs_stated_read(qs_stated *stated)
{
    /* Written here once, then only read. */
    read_sites(stated, (uint32_t *)stated->count, (size_t *)stated->start);
    read_tables(stated, (size_t *)stated->table_at, (int64_t *)stated->tables);
    stated->constant = stated->index->qubo->offset;
    stated->edge_count = 0;
    each_coupling(stated, add_edge);
    list_near(stated, (uint32_t *)stated->near_start, (uint32_t *)stated->near);
    memset(stated->kept, 1, stated->start[stated->sites]);
    memset(stated->settled, 0, stated->sites);
    stated->magnitude = find_magnitude(stated);
    stated->open_count = stated->sites;
}

static void fold_edge(qs_stated *stated, qs_stated_edge *edge, uint32_t site, uint32_t label)
{
    bool from_first = edge->first == site;
    uint32_t other = from_first ? edge->second : edge->first;
    for (uint32_t b = 0; b < stated->count[other]; b++) {
        stated->unary[qs_stated_at(stated, other, b)] +=
            from_first ? qs_stated_cost(stated, edge, label, b)
                       : qs_stated_cost(stated, edge, b, label);
    }
    edge->alive = false;
}

/* Settles a site that has one label left. */
static void settle(qs_stated *stated, uint32_t site)
{
    stated->settled[site] = QS_HAS_ONE_LABEL;
    stated->open_count--;
    for (uint32_t n = stated->near_start[site]; n < stated->near_start[site + 1]; n++) {
        qs_stated_edge *edge = &stated->edges[stated->near[n]];
        if (edge->alive) {
            fold_edge(stated, edge, site, stated->fixed[site]);
        }
    }
    stated->constant += stated->unary[qs_stated_at(stated, site, stated->fixed[site])];
}

void qs_stated_fold(qs_stated *stated, uint32_t site)
{
    uint32_t left = 0;
    if (stated->settled[site]) {
        return;
    }
    for (uint32_t a = 0; a < stated->count[site]; a++) {
        if (stated->kept[qs_stated_at(stated, site, a)]) {
            left++;
            stated->fixed[site] = a;
        }
    }
    stated->left[site] = left;
    if (left == 1) {
        settle(stated, site);
    }
}

void qs_stated_fold_all(qs_stated *stated)
{
    for (uint32_t p = 0; p < stated->sites; p++) {
        qs_stated_fold(stated, p);
    }
}

int64_t qs_stated_energy(const qs_stated *stated, const uint16_t *labelling)
{
    int64_t energy = stated->constant;
    for (uint32_t p = 0; p < stated->sites; p++) {
        energy += stated->unary[qs_stated_at(stated, p, labelling[p])];
    }
    for (uint32_t e = 0; e < stated->edge_count; e++) {
        const qs_stated_edge *edge = &stated->edges[e];
        energy += qs_stated_cost(stated, edge, labelling[edge->first], labelling[edge->second]);
    }
    return energy;
}
