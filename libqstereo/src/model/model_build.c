#include "../../include/qstereo/model.h"

#include <string.h>

#include "../base/arena.h"
#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../qubo/sites.h"
#include "edge_value.h"
#include "model_check.h"
#include "model_parts.h"

static bool is_grid(const qs_qubo *qubo)
{
    return qubo->has_labels && qubo->labels.width > 0;
}

/* Sites of the model. */
static uint32_t sites_of(const qs_qubo *qubo)
{
    return is_grid(qubo) ? qubo->labels.width * qubo->labels.height : qubo->labels.sites;
}

/* Tables of edges, at most; at least one, for the numbers that no edge has. */
static uint64_t most_tables(const qs_qubo *qubo)
{
    return 1 + (qubo->labels.fixed_bytes > 0 ? qubo->couplings : qubo->block_count);
}

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_parts(qs_building *b, const qs_qubo *qubo, void *workspace)
{
    const qs_labels *l = &qubo->labels;
    qs_arena arena = {.base = workspace};
    uint64_t sites = sites_of(qubo), labels = qubo->has_labels ? l->labels : 0;
    bool grid = is_grid(qubo), table = qubo->has_labels && l->pairwise.smoothness == QS_TABLE,
         tables = qubo->has_labels && l->pairwise.smoothness == QS_TABLES;
    b->unary = qs_arena_take(&arena, sites * labels, sizeof *b->unary);
    b->right = qs_arena_take(&arena, grid ? sites : 0, sizeof *b->right);
    b->down = qs_arena_take(&arena, grid ? sites : 0, sizeof *b->down);
    b->link_start = qs_arena_take(&arena, grid ? 0 : sites + 1, sizeof *b->link_start);
    b->cursor = qs_arena_take(&arena, grid ? 0 : sites, sizeof *b->cursor);
    b->links = qs_arena_take(&arena, grid ? 0 : qubo->couplings, 2 * sizeof *b->links);
    b->table = qs_arena_take(&arena, table ? labels * labels : 0, sizeof *b->table);
    uint64_t count = tables ? most_tables(qubo) : 0, numbers = grid ? 2 * sites : qubo->couplings;
    b->tables = qs_arena_take(&arena, count, labels * labels * sizeof *b->tables);
    b->table_max = qs_arena_take(&arena, count, sizeof *b->table_max);
    b->table_of = qs_arena_take(&arena, tables ? numbers : 0, sizeof *b->table_of);
    b->site_of = qs_arena_take(&arena, qubo->groups, sizeof *b->site_of);
    b->kept = qs_arena_take(&arena, l->fixed_bytes > 0 ? sites * labels : 0, sizeof *b->kept);
    return qs_arena_size(&arena);
}

size_t qs_model_workspace(const qs_qubo *qubo)
{
    qs_building b;
    return take_parts(&b, qubo, NULL);
}

static qs_building begin(const qs_index *index)
{
    const qs_qubo *qubo = index->qubo;
    const qs_labels *labels = &qubo->labels;
    return (qs_building){.index = index,
                         .labels = labels,
                         .model = {.sites = sites_of(qubo),
                                   .labels = labels->labels,
                                   .constant = qubo->offset,
                                   .pairwise = labels->pairwise,
                                   .width = labels->width,
                                   .height = labels->height,
                                   .mask = labels->mask}};
}

/* ---- Sites and their labels. ---- */

static void copy_set(const qs_building *b, uint32_t at, const qs_site *site)
{
    uint32_t labels = b->labels->labels;
    for (uint32_t d = 0; d < labels; d++) {
        b->kept[(size_t)at * labels + d] = qs_site_has(site, d);
    }
}

/* Notes the site of each group, and the labels of each site. */
static void place_sites(const qs_building *b)
{
    uint32_t at = 0;
    if (b->model.kept) {
        memset(b->kept, 1, (size_t)b->model.sites * b->labels->labels); /* masked cells, too */
    }
    for (qs_site site = {.labels = b->labels}; qs_site_next(&site); at++) {
        while (is_grid(b->index->qubo) && qs_is_masked(b->labels->mask, at)) {
            at++;
        }
        if (b->model.kept) {
            copy_set(b, at, &site);
        }
        if (site.is_undecided) {
            b->site_of[site.number] = at;
        }
    }
}

/* ---- Tables of edges. ---- */

/* Notes the table of the edge of a coupling. Blocks of whole problems are tables, and have been
 * copied; other blocks are smaller and stand for different labels. Returns false if it is no table
 * of costs. */
static bool enter_table(qs_building *b, uint32_t edge, uint32_t block, uint32_t first,
                        uint32_t second)
{
    size_t entries = (size_t)b->model.labels * b->model.labels;
    uint32_t table = b->model.kept ? b->table_count++ : block;
    b->table_of[edge] = table;
    return qs_copy_table(b, block, first, second, b->tables + table * entries);
}

static void begin_tables(qs_building *b)
{
    const qs_model *model = &b->model;
    size_t entries = (size_t)model->labels * model->labels,
           numbers =
               model->width > 0 ? 2 * (size_t)model->sites : (size_t)b->index->qubo->couplings;
    b->table_count = model->kept ? 1 : b->index->qubo->block_count + 1;
    memset(b->tables, 0, sizeof *b->tables * entries * b->table_count);
    memset(b->table_of, 0, sizeof *b->table_of * numbers);
}

static void end_tables(qs_building *b)
{
    qs_find_table_max(b->tables, b->table_count, b->model.labels, b->table_max);
    b->model.tables = b->tables;
    b->model.table_of = b->table_of;
    b->model.table_max = b->table_max;
}

static bool has_tables(const qs_building *b)
{
    return b->labels->pairwise.smoothness == QS_TABLES;
}

/* ---- The edges. ---- */

/* Adds the weights of the couplings to the edges of the grid. Returns false if a coupling is no
 * edge of it, a sum is too large, or an edge has two tables. */
static bool copy_grid(qs_building *b)
{
    const qs_index *index = b->index;
    memset(b->right, 0, sizeof *b->right * b->model.sites);
    memset(b->down, 0, sizeof *b->down * b->model.sites);
    for (uint32_t group = 0; group < index->qubo->groups; group++) {
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group <= group) {
                continue;
            }
            uint32_t cell = b->site_of[group], other = b->site_of[near->group];
            bool to_right = other == cell + 1 && other % b->model.width != 0,
                 to_below = other == cell + b->model.width;
            int32_t *weight = to_right ? &b->right[cell] : &b->down[cell];
            if ((!to_right && !to_below) || near->weight > INT32_MAX - *weight) {
                return false;
            }
            uint32_t edge = qs_cell_edge(cell, to_below);
            if (has_tables(b) &&
                (*weight != 0 || !enter_table(b, edge, near->block, cell, other))) {
                return false;
            }
            *weight += near->weight;
        }
    }
    return true;
}

/* Enters each site, in order, in the lists of its neighbours. So the lists are sorted. The links
 * hold the blocks of their edges, until they get the edges' numbers. */
static void enter_sites(const qs_building *b)
{
    const qs_index *index = b->index;
    memset(b->link_start, 0, sizeof *b->link_start * (b->model.sites + (size_t)1));
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            b->link_start[b->site_of[g] + 1] += index->near[n].group != g;
        }
    }
    for (uint32_t p = 0; p < b->model.sites; p++) {
        b->cursor[p] = b->link_start[p];
        b->link_start[p + 1] += b->link_start[p];
    }
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group != g) {
                b->links[b->cursor[b->site_of[near->group]]++] =
                    (qs_link){b->site_of[g], near->block & ~QS_TRANSPOSED, near->weight};
            }
        }
    }
}

/* The tables of the edges of a graph, from the blocks in the links. */
static bool find_tables(qs_building *b)
{
    uint32_t edges = 0;
    bool fits = true;
    for (uint32_t p = 0; p < b->model.sites; p++) {
        for (uint32_t n = b->link_start[p]; n < b->link_start[p + 1]; n++) {
            const qs_link *link = &b->links[n];
            if (link->site > p) {
                fits &= enter_table(b, edges++, link->edge, p, link->site);
            }
        }
    }
    return fits;
}

/* ---- The costs. ---- */

/* The number of the edge of two neighbours: see qs_model_edge_pairwise. */
static uint32_t number_of_edge(const qs_building *b, uint32_t p, uint32_t q)
{
    uint32_t lower = qs_min_u32(p, q), higher = qs_max_u32(p, q), width = b->model.width;
    if (width > 0) {
        return qs_cell_edge(lower, !(higher == lower + 1 && higher % width != 0));
    }
    uint32_t n = b->link_start[lower];
    while (b->links[n].site != higher) {
        n++;
    }
    return b->links[n].edge;
}

/* V of the edge of two groups, for a label of each. */
static int64_t value_between(const qs_building *b, uint32_t group, uint32_t other, uint32_t d,
                             uint32_t e)
{
    if (!has_tables(b)) {
        return qs_value(b, d, e); /* symmetric: tables of all edges are none in walls */
    }
    uint32_t p = b->site_of[group], q = b->site_of[other], edge = number_of_edge(b, p, q);
    return p < q ? qs_edge_value(&b->model, edge, d, e) : qs_edge_value(&b->model, edge, e, d);
}

/* What the edges and the chain have put into the linear term of a wall's variable.
 *
 * d       the first label at which the variable is 1
 * before  the label left before it
 * rank    how many labels are left before d */
static int64_t wall_share(const qs_building *b, uint32_t group, uint32_t rank, uint32_t before,
                          uint32_t d)
{
    const qs_index *index = b->index;
    int64_t share = 0;
    for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group == group) {
            if (rank > 1) {
                int64_t entry = qs_index_block(index, near->block, rank - 2, rank - 1);
                share -= entry * near->weight;
            }
        } else {
            uint32_t lowest = qs_next_label(b, near->group, 0);
            share += near->weight * (value_between(b, group, near->group, d, lowest) -
                                     value_between(b, group, near->group, before, lowest));
        }
    }
    return share;
}

/* What the encoding has put into the offset for an edge, in units of its weight: with sparse blocks
 * the most that it costs, with walls what it costs with the lowest labels. */
static int64_t edge_share(const qs_building *b, uint32_t group, uint32_t other)
{
    switch (b->labels->encoding) {
    case QS_ONE_HOT_SPARSE: return b->tau;
    case QS_DOMAIN_WALL:
        return value_between(b, group, other, qs_next_label(b, group, 0),
                             qs_next_label(b, other, 0));
    default: return 0;
    }
}

/* The same for all edges of a group to later ones. */
static int64_t edges_share(const qs_building *b, uint32_t group)
{
    const qs_index *index = b->index;
    int64_t share = 0;
    for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group > group) {
            share += near->weight * edge_share(b, group, near->group);
        }
    }
    return share;
}

/* The labels left to an undecided site, one after another, with the cost of each. */
typedef struct site_costs {
    const qs_building *b;
    uint32_t group;
    const uint8_t *trimmed; /* what truncation took from each; NULL = nothing */
    uint32_t next; /* how many there have been */
    uint32_t label;
    int64_t cost;
    int64_t wall; /* with walls: the sum of their linear terms up to the label, less the shares */
} site_costs;

/* The next label. Returns false after the last. */
static bool next_cost(site_costs *c)
{
    const qs_building *b = c->b;
    const qs_qubo *qubo = b->index->qubo;
    uint32_t rank = c->next++, before = c->label, first = b->index->start[c->group];
    c->label = qs_next_label(b, c->group, rank > 0 ? before + 1 : 0);
    if (c->label == b->labels->labels) {
        return false;
    }
    if (!qs_has_walls(b)) {
        c->cost = qs_qubo_linear(qubo, first + rank);
    } else {
        if (rank > 0) {
            c->wall += qs_qubo_linear(qubo, first + rank - 1) -
                       wall_share(b, c->group, rank, before, c->label);
        }
        c->cost = c->wall;
    }
    if (c->trimmed) {
        unsigned bytes = b->labels->trimmed_bytes;
        c->cost += (int64_t)qs_load_unsigned(c->trimmed + (size_t)rank * bytes, bytes);
    }
    return true;
}

/* The costs of an undecided site, less their least, which goes into the constant. Returns false if
 * one is too large. */
static bool copy_site(qs_building *b, uint32_t group, const uint8_t *trimmed)
{
    int32_t *costs = b->unary + (size_t)b->site_of[group] * b->labels->labels;
    const site_costs begin = {.b = b, .group = group, .trimmed = trimmed};
    int64_t least = INT64_MAX;
    for (site_costs c = begin; next_cost(&c);) {
        least = qs_min_i64(least, c.cost);
    }
    for (site_costs c = begin; next_cost(&c);) {
        if (c.cost - least > INT32_MAX) {
            return false;
        }
        costs[c.label] = (int32_t)(c.cost - least);
    }
    b->model.constant += least - edges_share(b, group);
    return true;
}

/* The costs of all sites. The one label of a fixed site costs 0. */
static bool copy_costs(qs_building *b)
{
    const qs_labels *l = b->labels;
    const uint8_t *trimmed = l->trimmed;
    memset(b->unary, 0, sizeof *b->unary * b->model.sites * l->labels);
    for (uint32_t group = 0; group < b->index->qubo->groups; group++) {
        if (!copy_site(b, group, trimmed)) {
            return false;
        }
        if (trimmed) {
            trimmed += (size_t)qs_labels_left(b, group) * l->trimmed_bytes;
        }
    }
    for (uint32_t p = 0; b->model.kept && p < b->model.sites; p++) {
        qs_leave_out(&b->model, b->kept, p, b->unary); /* the costs have 0 as their least */
    }
    return true;
}

/* Returns false: couplings beyond the grid, weights too large, or blocks that are no tables. */
static bool copy_graph(qs_building *b)
{
    qs_model *model = &b->model;
    if (model->width > 0) {
        model->right = b->right;
        model->down = b->down;
        return copy_grid(b);
    }
    enter_sites(b);
    if (has_tables(b) && !find_tables(b)) {
        return false;
    }
    model->edges = qs_number_links(b->link_start, model->sites, b->links, b->cursor);
    model->link_start = b->link_start;
    model->links = b->links;
    return true;
}

static qs_status build(qs_building *b)
{
    qs_model *model = &b->model;
    const qs_labels *l = b->labels;
    bool table = model->pairwise.smoothness == QS_TABLE;
    if (!qs_encoding_holds(l->encoding, &l->pairwise, l->labels)) {
        return QS_E_CORRUPT;
    }
    model->kept = l->fixed_bytes > 0 ? b->kept : NULL;
    if (table) {
        size_t count = (size_t)model->labels * model->labels;
        memset(b->table, 0xff, sizeof *b->table * count); /* -1: not seen yet */
        model->pairwise.table = b->table;
    } else if (!has_tables(b)) {
        /* Of Potts it is 1, even where there is one label. */
        b->tau = model->pairwise.smoothness == QS_POTTS ? 1 : qs_largest_pairwise(model);
    }
    place_sites(b);
    if (has_tables(b)) {
        begin_tables(b);
    }
    if (!qs_couplings_agree(b) || !copy_graph(b) || (table && !qs_finish_table(b))) {
        return QS_E_CORRUPT;
    }
    if (has_tables(b)) {
        end_tables(b);
    }
    model->pairwise_max = qs_largest_pairwise(model);
    model->unary = b->unary;
    return qs_sums_fit(model) && copy_costs(b) ? QS_OK : QS_E_OVERFLOW;
}

qs_status qs_model_build(const qs_index *index, void *workspace, size_t workspace_size,
                         qs_model *model)
{
    if (!index || !workspace || !model) {
        return QS_E_ARGUMENT;
    }
    const qs_qubo *qubo = index->qubo;
    if (!qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    const qs_encoding_facts *facts = qs_encoding_facts_of(qubo->labels.encoding);
    if (!facts || !facts->has_model) {
        return QS_E_ENCODING;
    }
    qs_building b = begin(index);
    if (workspace_size < take_parts(&b, qubo, workspace)) {
        return QS_E_WORKSPACE;
    }
    qs_status status = build(&b);
    if (status == QS_OK) {
        *model = b.model;
    }
    return status;
}
