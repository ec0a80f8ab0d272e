#include "edge_tables.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "edge_runs.h"

static size_t entries_of(const qs_problem *problem)
{
    return (size_t)problem->labels * problem->labels;
}

qs_table_strip qs_table_strip_first(const qs_problem *problem, qs_arena *arena)
{
    uint64_t width = problem->grid.width, tables = width > 0 ? 2 * width - 1 : 0;
    qs_table_strip strip = {.problem = problem};
    strip.tables = qs_arena_take(arena, tables, entries_of(problem) * sizeof *strip.tables);
    strip.here = qs_arena_take(arena, width, sizeof *strip.here);
    strip.below = qs_arena_take(arena, width, sizeof *strip.below);
    return strip;
}

/* ---- Strips. ---- */

/* Numbers the sites of a row; returns the number of the first site behind it. */
static uint32_t number_row(const qs_grid *grid, uint32_t y, uint32_t site, uint32_t *numbers)
{
    for (uint32_t x = 0; x < grid->width; x++) {
        numbers[x] = site;
        site += qs_is_site(grid, x, y);
    }
    return site;
}

/* Moves on to the numbers of a row and of the one below it. */
static void number_rows(qs_table_strip *strip, uint32_t y)
{
    const qs_grid *grid = &strip->problem->grid;
    if (y == 0) {
        (void)number_row(grid, 0, 0, strip->below);
    }
    uint32_t last = grid->width - 1, *free_row = strip->here,
             end = strip->below[last] + qs_is_site(grid, last, y);
    strip->here = strip->below;
    strip->below = free_row;
    (void)number_row(grid, y + 1, end, strip->below);
}

bool qs_table_strip_next(qs_table_strip *strip)
{
    const qs_problem *problem = strip->problem;
    const qs_grid *grid = &problem->grid;
    if (grid->width == 0) {
        strip->count = (uint32_t)problem->edge_count;
        return strip->row++ == 0;
    }
    if (!strip->down && (strip->row == grid->height || grid->width == 1)) {
        strip->down = true;
        strip->row = 0;
    }
    if (strip->down && strip->row + 1 == grid->height) {
        return false;
    }
    number_rows(strip, strip->row);
    strip->count = strip->down ? grid->width : grid->width - 1;
    problem->table_source.row(problem->table_source.context, strip->row,
                              strip->down ? NULL : strip->tables,
                              strip->down ? strip->tables : NULL);
    strip->row++;
    return true;
}

qs_table_edge qs_table_edge_at(const qs_table_strip *strip, uint32_t at)
{
    const qs_problem *problem = strip->problem;
    size_t entries = entries_of(problem);
    if (problem->grid.width == 0) {
        const qs_edge *edge = &problem->edges[at];
        return (qs_table_edge){edge->first, edge->second, edge->weight,
                               problem->tables + at * entries};
    }
    uint32_t site = strip->here[at];
    return (qs_table_edge){site, strip->down ? strip->below[at] : site + 1,
                           qs_cell_weight(problem, at, strip->row - 1, strip->down),
                           strip->tables + at * entries};
}

/* ---- What edges can cost. ---- */

uint64_t qs_table_reach_numbers(const qs_problem *problem)
{
    uint64_t sites = problem->grid.width > 0 ? 2 * (uint64_t)problem->grid.width : problem->sites;
    return sites * problem->labels;
}

/* Adds to each label of both sites of an edge what the edge can cost it. */
static void reach_along(const qs_problem *problem, int32_t weight, const int32_t *table,
                        uint64_t *first, uint64_t *second)
{
    uint32_t labels = problem->labels;
    for (uint32_t a = 0; weight > 0 && a < labels; a++) {
        int32_t row = 0, column = 0;
        for (uint32_t b = 0; b < labels; b++) {
            row = qs_max_i32(row, table[(size_t)a * labels + b]);
            column = qs_max_i32(column, table[(size_t)b * labels + a]);
        }
        qs_grow(&first[a], (uint64_t)weight, (uint64_t)row);
        qs_grow(&second[a], (uint64_t)weight, (uint64_t)column);
    }
}

static uint64_t largest_of(const uint64_t *reach, uint32_t labels)
{
    uint64_t most = 0;
    for (uint32_t d = 0; d < labels; d++) {
        most = qs_max_u64(most, reach[d]);
    }
    return most;
}

/* `here` and `below` are the cells of this row and of the next one. */
static void reach_row(const qs_table_strip *strip, uint32_t y, uint64_t *here, uint64_t *below)
{
    const qs_problem *problem = strip->problem;
    uint32_t width = problem->grid.width;
    size_t labels = problem->labels, entries = entries_of(problem);
    int32_t *right = strip->tables, *down = right + (width - 1) * entries;
    bool last = y + 1 == problem->grid.height;
    problem->table_source.row(problem->table_source.context, y, width > 1 ? right : NULL,
                              last ? NULL : down);
    for (uint32_t x = 0; x < width; x++) {
        reach_along(problem, qs_cell_weight(problem, x, y, false), right + x * entries,
                    here + x * labels, here + (x + 1) * labels);
        reach_along(problem, qs_cell_weight(problem, x, y, true), down + x * entries,
                    here + x * labels, below + x * labels);
    }
}

static void reach_grid(const qs_table_strip *strip, uint64_t *reach, qs_table_reach_visit *visit,
                       void *context)
{
    const qs_grid *grid = &strip->problem->grid;
    size_t labels = strip->problem->labels, row = grid->width * labels;
    uint64_t *here = reach, *below = reach + row;
    memset(here, 0, sizeof *here * row);
    for (uint32_t y = 0; y < grid->height; y++) {
        memset(below, 0, sizeof *below * row);
        reach_row(strip, y, here, below);
        for (uint32_t x = 0; x < grid->width; x++) {
            if (qs_is_site(grid, x, y)) {
                visit(context, largest_of(here + x * labels, (uint32_t)labels));
            }
        }
        uint64_t *next = below;
        below = here;
        here = next;
    }
}

void qs_table_reach_all(const qs_table_strip *strip, uint64_t *reach, qs_table_reach_visit *visit,
                        void *context)
{
    const qs_problem *problem = strip->problem;
    size_t labels = problem->labels, entries = entries_of(problem);
    if (problem->grid.width > 0) {
        reach_grid(strip, reach, visit, context);
        return;
    }
    memset(reach, 0, sizeof *reach * labels * problem->sites);
    for (size_t e = 0; e < problem->edge_count; e++) {
        const qs_edge *edge = &problem->edges[e];
        reach_along(problem, edge->weight, problem->tables + e * entries,
                    reach + edge->first * labels, reach + edge->second * labels);
    }
    for (uint32_t p = 0; p < problem->sites; p++) {
        visit(context, largest_of(reach + p * labels, (uint32_t)labels));
    }
}
