#include "../../include/qstereo/model.h"

#include <string.h>

#include "../base/arena.h"
#include "../problem/cost_strips.h"
#include "edge_value.h"
#include "labels_of_problem.h"
#include "model_parts.h"

/* A model under construction: its arrays, to be written. */
typedef struct layout {
    const qs_problem *problem;
    qs_model model;
    int32_t *unary, *right, *down;
    uint32_t *link_start, *cursor;
    qs_link *links;
    uint8_t *mask, *kept;
    /* Tables of edges. Those of a list stay where they are. */
    uint32_t *table_of;
    int32_t *table_max, *tables, *table_row;
    uint32_t table_count;
    bool bad_table; /* an entry is below 0 */
    void *strip; /* workspace of the strips */
    bool overflow; /* a cost is above 2^31 - 1 */
} layout;

static bool has_tables(const qs_problem *problem)
{
    return problem->pairwise.smoothness == QS_TABLES;
}

/* Edges of a problem, at most. */
static uint64_t edge_count(const qs_problem *problem)
{
    const qs_grid *grid = &problem->grid;
    uint64_t width = grid->width, height = grid->height;
    return width > 0 ? (width - 1) * height + width * (height - 1) : problem->edge_count;
}

/* Entries of a row's tables: those of the edges to the right, then those of the edges down. */
static uint64_t row_entries(const qs_problem *problem)
{
    uint64_t each = (uint64_t)problem->labels * problem->labels;
    return (2 * (uint64_t)problem->grid.width - 1) * each;
}

static uint32_t cells_of(const qs_problem *problem)
{
    const qs_grid *grid = &problem->grid;
    return grid->width > 0 ? grid->width * grid->height : problem->sites;
}

/* A problem without edges has one table all the same: for the numbers that no edge has. */
static void take_tables(layout *l, const qs_problem *problem, qs_arena *arena)
{
    bool any = has_tables(problem), grid = problem->grid.width > 0;
    uint64_t entries = (uint64_t)problem->labels * problem->labels, edges = edge_count(problem),
             numbers = grid ? 2 * (uint64_t)cells_of(problem) : edges;
    l->table_of = qs_arena_take(arena, any ? numbers : 0, sizeof *l->table_of);
    l->table_max = qs_arena_take(arena, any ? edges + 1 : 0, sizeof *l->table_max);
    l->tables = qs_arena_take(arena, any && grid ? edges + 1 : 0, entries * sizeof *l->tables);
    l->table_row =
        qs_arena_take(arena, any && grid ? row_entries(problem) : 0, sizeof *l->table_row);
}

/* Hands out the workspace, or counts it. Returns its size. */
static size_t take_parts(layout *l, const qs_problem *problem, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t sites = cells_of(problem);
    bool grid = problem->grid.width > 0;
    l->unary = qs_arena_take(&arena, sites * problem->labels, sizeof *l->unary);
    l->right = qs_arena_take(&arena, grid ? sites : 0, sizeof *l->right);
    l->down = qs_arena_take(&arena, grid ? sites : 0, sizeof *l->down);
    l->link_start = qs_arena_take(&arena, grid ? 0 : sites + 1, sizeof *l->link_start);
    l->cursor = qs_arena_take(&arena, grid ? 0 : sites, sizeof *l->cursor);
    l->links = qs_arena_take(&arena, grid ? 0 : problem->edge_count, 2 * sizeof *l->links);
    l->mask = qs_arena_take(&arena, problem->grid.mask ? (sites + 7) / 8 : 0, 1);
    l->kept = qs_arena_take(&arena, problem->allowed ? sites * problem->labels : 0, 1);
    take_tables(l, problem, &arena);
    l->strip = qs_arena_take(&arena, qs_costs_workspace(problem), 1);
    return qs_arena_size(&arena);
}

size_t qs_model_of_problem_workspace(const qs_problem *problem)
{
    layout l;
    return take_parts(&l, problem, NULL);
}

/* The mask as a file holds it, a bit a cell. A mask that masks nothing is none. */
static void copy_mask(layout *l)
{
    const uint8_t *mask = l->problem->grid.mask;
    uint32_t cells = l->model.sites;
    if (!mask || qs_problem_sites(l->problem) == cells) {
        return;
    }
    memset(l->mask, 0, ((size_t)cells + 7) / 8);
    for (uint32_t i = 0; i < cells; i++) {
        l->mask[i / 8] |= (uint8_t)((mask[i] != 0) << i % 8);
    }
    l->model.mask = l->mask;
}

/* ---- The edges. ---- */

static bool is_site(const qs_grid *grid, size_t cell)
{
    return !grid->mask || grid->mask[cell] != 0;
}

/* Weights of the edges from the cells of row y to those at a distance of `step` cells, the first
 * `count` of them. The others of the row have no such edge. */
static void copy_row(const layout *l, uint32_t y, uint32_t count, uint32_t step,
                     const int32_t *given, int32_t *weights)
{
    const qs_grid *grid = &l->problem->grid;
    size_t first = (size_t)y * grid->width;
    for (uint32_t x = 0; x < grid->width; x++) {
        size_t cell = first + x;
        bool edge = x < count && is_site(grid, cell) && is_site(grid, cell + step);
        int32_t weight = given ? given[cell] : l->problem->weight;
        weights[cell] = edge ? weight : 0;
    }
}

static void copy_grid(layout *l)
{
    const qs_grid *grid = &l->problem->grid;
    for (uint32_t y = 0; y < grid->height; y++) {
        bool last = y + 1 == grid->height;
        copy_row(l, y, grid->width - 1, 1, grid->right, l->right);
        copy_row(l, y, last ? 0 : grid->width, grid->width, grid->down, l->down);
    }
    l->model.right = l->right;
    l->model.down = l->down;
}

/* ---- Tables of edges. ---- */

/* Notes the table of an edge. A table like that of the edge before is not kept twice. */
static void enter_table(layout *l, uint32_t edge, const int32_t *table)
{
    size_t entries = (size_t)l->model.labels * l->model.labels;
    int32_t *next = l->tables + l->table_count * entries;
    for (size_t i = 0; i < entries; i++) {
        l->bad_table |= table[i] < 0;
    }
    if (l->table_count == 0 || memcmp(next - entries, table, entries * sizeof *table) != 0) {
        memcpy(next, table, entries * sizeof *table);
        l->table_count++;
    }
    l->table_of[edge] = l->table_count - 1;
}

/* The tables of the edges that begin in a row and have a weight. */
static void enter_table_row(layout *l, uint32_t y, bool down)
{
    const qs_problem *problem = l->problem;
    const int32_t *weights = down ? l->down : l->right, *table = l->table_row;
    size_t entries = (size_t)l->model.labels * l->model.labels;
    uint32_t width = problem->grid.width, count = down ? width : width - 1;
    problem->table_source.row(problem->table_source.context, y, down ? NULL : l->table_row,
                              down ? l->table_row : NULL);
    for (uint32_t x = 0; x < count; x++, table += entries) {
        uint32_t cell = y * width + x;
        if (weights[cell] != 0) {
            enter_table(l, qs_cell_edge(cell, down), table);
        }
    }
}

/* Of a grid. The weights have been copied. */
static void make_tables(layout *l)
{
    const qs_grid *grid = &l->problem->grid;
    size_t entries = (size_t)l->model.labels * l->model.labels;
    memset(l->tables, 0, entries * sizeof *l->tables);
    memset(l->table_of, 0, sizeof *l->table_of * 2 * l->model.sites);
    for (uint32_t y = 0; grid->width > 1 && y < grid->height; y++) {
        enter_table_row(l, y, false);
    }
    for (uint32_t y = 0; y + 1 < grid->height; y++) {
        enter_table_row(l, y, true);
    }
    l->table_count += l->table_count == 0;
    l->model.tables = l->tables;
}

static bool all_weights_are_0(const qs_problem *problem)
{
    for (size_t e = 0; e < problem->edge_count; e++) {
        if (problem->edges[e].weight != 0) {
            return false;
        }
    }
    return true;
}

/* Counts each site's links into link_start, as the first site of each, and sets the cursors behind
 * the links to lower sites. */
static void count_links(const layout *l)
{
    const qs_problem *problem = l->problem;
    memset(l->link_start, 0, sizeof *l->link_start * (l->model.sites + (size_t)1));
    memset(l->cursor, 0, sizeof *l->cursor * l->model.sites);
    for (size_t e = 0; e < problem->edge_count; e++) {
        const qs_edge *edge = &problem->edges[e];
        l->link_start[edge->first + 1]++;
        l->link_start[edge->second + 1]++;
        l->cursor[edge->second]++;
    }
    for (uint32_t p = 0; p < l->model.sites; p++) {
        l->link_start[p + 1] += l->link_start[p];
        l->cursor[p] += l->link_start[p];
    }
}

/* Enters each edge at both its sites, so that the links of every site are sorted by the other one.
 * No sort is needed: first the edges go to their first sites in any order. Going through those in
 * order, each edge is appended at its second site: so links to lower sites are sorted. Going
 * through the second sites in order, each is appended at its first site: so are those to higher
 * ones. */
static void enter_links(const layout *l)
{
    const qs_problem *problem = l->problem;
    uint32_t sites = l->model.sites, *start = l->link_start, *cursor = l->cursor;
    for (size_t e = 0; e < problem->edge_count; e++) {
        const qs_edge *edge = &problem->edges[e];
        l->links[cursor[edge->first]++] = (qs_link){edge->second, (uint32_t)e, edge->weight};
    }
    /* The cursors have come to the ends. Each now runs through its site's lower links, and stops
     * where the higher ones begin. */
    memcpy(cursor, start, sizeof *cursor * sites);
    for (uint32_t p = 0; p < sites; p++) {
        for (uint32_t n = cursor[p]; n < start[p + 1]; n++) {
            const qs_link *link = &l->links[n];
            l->links[cursor[link->site]++] = (qs_link){p, link->edge, link->weight};
        }
    }
    for (uint32_t q = 0; q < sites; q++) {
        for (uint32_t n = start[q]; n < start[q + 1] && l->links[n].site < q; n++) {
            const qs_link *link = &l->links[n];
            l->links[cursor[link->site]++] = (qs_link){q, link->edge, link->weight};
        }
    }
}

/* The tables of a list. The links hold the places of their edges in the list, which are those of
 * their tables; they get the numbers of the edges next. */
static void find_tables(layout *l)
{
    uint32_t edges = 0;
    for (uint32_t p = 0; p < l->model.sites; p++) {
        for (uint32_t n = l->link_start[p]; n < l->link_start[p + 1]; n++) {
            if (l->links[n].site > p) {
                l->table_of[edges++] = l->links[n].edge;
            }
        }
    }
}

/* Edges whose weights are all 0 are none, as in a file. */
static void copy_edges(layout *l)
{
    qs_model *model = &l->model;
    if (has_tables(l->problem)) {
        l->table_count = (uint32_t)l->problem->edge_count;
        model->tables = l->table_count > 0 ? l->problem->tables : l->table_max;
    }
    if (all_weights_are_0(l->problem)) {
        memset(l->link_start, 0, sizeof *l->link_start * (model->sites + (size_t)1));
    } else {
        count_links(l);
        enter_links(l);
        if (has_tables(l->problem)) {
            find_tables(l);
        }
        model->edges = qs_number_links(l->link_start, model->sites, l->links, l->cursor);
    }
    model->link_start = l->link_start;
    model->links = l->links;
}

/* ---- The costs. ---- */

/* Copies costs of 1 or 4 bytes; notes if one is above 2^31 - 1. */
static void copy_costs(layout *l, const void *from, unsigned bytes, int32_t *to, size_t count)
{
    if (bytes == 1) {
        const uint8_t *narrow = from;
        for (size_t i = 0; i < count; i++) {
            to[i] = narrow[i];
        }
        return;
    }
    const uint32_t *wide = from;
    uint32_t any = 0;
    for (size_t i = 0; i < count; i++) {
        any |= wide[i];
        to[i] = (int32_t)(wide[i] & INT32_MAX);
    }
    l->overflow |= any > INT32_MAX;
}

/* The costs of a strip of unmasked cells, the first of them at or after `cell`. Returns the cell
 * after the last. */
static uint32_t copy_strip(layout *l, const qs_strip *strip, uint32_t cell)
{
    size_t labels = l->model.labels, each = strip->bytes * labels;
    const char *from = strip->costs;
    if (!l->model.mask) {
        copy_costs(l, from, strip->bytes, l->unary + cell * labels, strip->sites * labels);
        return cell + strip->sites;
    }
    for (uint32_t i = 0; i < strip->sites; i++, cell++) {
        while (!is_site(&l->problem->grid, cell)) {
            cell++;
        }
        copy_costs(l, from + i * each, strip->bytes, l->unary + cell * labels, labels);
    }
    return cell;
}

/* Each site's least cost goes into the constant. Masked cells have no costs. */
static void copy_unary(layout *l)
{
    uint32_t cell = 0;
    if (l->model.mask) {
        memset(l->unary, 0, sizeof *l->unary * l->model.sites * l->model.labels);
    }
    qs_strip strip = qs_strip_first(l->problem, l->strip);
    while (qs_strip_next(&strip)) {
        cell = copy_strip(l, &strip, cell);
        l->model.constant += strip.least_sum;
    }
    l->model.unary = l->unary;
}

/* Leaves the forbidden labels out. If there are none, the model has no sets. The costs of a site
 * are less the least of the labels that are left. */
static void copy_allowed(layout *l)
{
    const uint8_t *allowed = l->problem->allowed;
    size_t labels = l->model.labels;
    bool any = false;
    memset(l->kept, 1, l->model.sites * labels); /* masked cells, too */
    for (uint32_t p = 0; p < l->model.sites; p++) {
        if (l->model.mask && !is_site(&l->problem->grid, p)) {
            continue;
        }
        for (size_t at = p * labels; at < (p + (size_t)1) * labels; at++) {
            l->kept[at] = *allowed++ != 0;
            any |= l->kept[at] == 0;
        }
    }
    if (any) {
        l->model.kept = l->kept;
        for (uint32_t p = 0; p < l->model.sites; p++) {
            l->model.constant += qs_leave_out(&l->model, l->kept, p, l->unary);
        }
    }
}

/* ---- All of it. ---- */

static qs_status lay_out(layout *l)
{
    const qs_problem *problem = l->problem;
    qs_model *model = &l->model;
    model->sites = cells_of(problem);
    model->labels = problem->labels;
    model->pairwise = qs_pairwise_of(problem);
    copy_mask(l);
    if (problem->grid.width > 0) {
        model->width = problem->grid.width;
        model->height = problem->grid.height;
        copy_grid(l);
        if (has_tables(problem)) {
            make_tables(l);
        }
    } else {
        copy_edges(l);
    }
    if (has_tables(problem)) {
        qs_find_table_max(model->tables, l->table_count, model->labels, l->table_max);
        model->table_of = l->table_of;
        model->table_max = l->table_max;
    }
    model->pairwise_max = qs_largest_pairwise(model);
    if (l->bad_table) {
        return QS_E_ARGUMENT;
    }
    if (model->pairwise_max > INT32_MAX || !qs_sums_fit(model)) {
        return QS_E_OVERFLOW;
    }
    copy_unary(l);
    if (problem->allowed) {
        copy_allowed(l);
    }
    return l->overflow ? QS_E_OVERFLOW : QS_OK;
}

qs_status qs_model_of_problem(const qs_problem *problem, void *workspace, size_t workspace_size,
                              qs_model *model, qs_labels *labels)
{
    qs_status status = qs_problem_check(problem);
    if (status != QS_OK) {
        return status;
    }
    if (!workspace || !model) {
        return QS_E_ARGUMENT;
    }
    layout l = {.problem = problem};
    if (workspace_size < take_parts(&l, problem, workspace)) {
        return QS_E_WORKSPACE;
    }
    status = lay_out(&l);
    if (status == QS_OK) {
        *model = l.model;
        if (labels) {
            *labels = qs_labels_with_mask(problem, l.model.mask);
        }
    }
    return status;
}
