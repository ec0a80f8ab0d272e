#include "edge_runs.h"

#include <string.h>

static uint32_t sites_in_row(const qs_grid *grid, uint32_t y)
{
    uint32_t count = 0;
    for (uint32_t x = 0; x < grid->width; x++) {
        count += qs_is_site(grid, x, y);
    }
    return count;
}

static void whole_grid(const qs_problem *problem, qs_edge_visit *visit, void *context)
{
    const qs_grid *grid = &problem->grid;
    uint32_t width = grid->width, height = grid->height;
    if (width > 1) {
        bool rows = height > 1;
        qs_edge_run right = {0, 1, width - 1, height, rows ? width : 0, NULL, grid->right, width};
        visit(context, &right);
    }
    if (height > 1) {
        qs_edge_run down = {0, width, width * (height - 1), 1, 0, NULL, grid->down, 0};
        visit(context, &down);
    }
}

/* The edges of a row of a masked grid, to the right or down: a run for each longest sequence of
 * them.
 *
 * site, below  number of the first site in this row, and in the next one */
static void masked_row(const qs_grid *grid, uint32_t y, bool down, uint32_t site, uint32_t below,
                       qs_edge_visit *visit, void *context)
{
    const int32_t *weights = down ? grid->down : grid->right;
    qs_edge_run run = {.repeat = 1};
    for (uint32_t x = 0; x < grid->width; x++) {
        bool here = qs_is_site(grid, x, y), there = down && qs_is_site(grid, x, y + 1);
        bool pair = here && (down ? there : x + 1 < grid->width && qs_is_site(grid, x + 1, y));
        if (pair && run.count++ == 0) {
            run.first = site;
            run.second = down ? below : site + 1;
            run.weights = weights ? weights + (size_t)y * grid->width + x : NULL;
        }
        if (run.count > 0 && (!pair || x + 1 == grid->width)) {
            visit(context, &run);
            run.count = 0;
        }
        site += here;
        below += there;
    }
}

static void masked_grid(const qs_grid *grid, bool down, qs_edge_visit *visit, void *context)
{
    uint32_t site = 0;
    for (uint32_t y = 0; y + down < grid->height; y++) {
        uint32_t below = site + sites_in_row(grid, y);
        masked_row(grid, y, down, site, below, visit, context);
        site = below;
    }
}

void qs_edges_visit(const qs_problem *problem, qs_edge_visit *visit, void *context)
{
    const qs_grid *grid = &problem->grid;
    if (grid->width == 0) {
        if (problem->edge_count > 0) {
            qs_edge_run list = {
                .count = (uint32_t)problem->edge_count, .repeat = 1, .list = problem->edges};
            visit(context, &list);
        }
    } else if (problem->weight == 0 && !grid->right) {
        return;
    } else if (!grid->mask) {
        whole_grid(problem, visit, context);
    } else {
        masked_grid(grid, false, visit, context);
        masked_grid(grid, true, visit, context);
    }
}

int32_t qs_edge_weight(const qs_problem *problem, const qs_edge_run *run, uint32_t r, uint32_t c)
{
    if (run->list) {
        return run->list[c].weight;
    }
    return run->weights ? run->weights[r * run->pitch + c] : problem->weight;
}

int32_t qs_cell_weight(const qs_problem *problem, uint32_t x, uint32_t y, bool down)
{
    const qs_grid *grid = &problem->grid;
    const int32_t *weights = down ? grid->down : grid->right;
    uint32_t to_x = x + !down, to_y = y + down;
    if (to_x == grid->width || !qs_is_site(grid, x, y) || !qs_is_site(grid, to_x, to_y)) {
        return 0;
    }
    return weights ? weights[(size_t)y * grid->width + x] : problem->weight;
}

static void visit_cell(const qs_problem *problem, uint32_t x, uint32_t y, uint32_t count,
                       qs_reach_visit *visit, void *context)
{
    int64_t first = qs_cell_weight(problem, x, y, false);
    int64_t second = x > 0 ? qs_cell_weight(problem, x - 1, y, false) : 0;
    first += qs_cell_weight(problem, x, y, true);
    second += y > 0 ? qs_cell_weight(problem, x, y - 1, true) : 0;
    visit(context, count, first, second);
}

static void visit_grid(const qs_problem *problem, qs_reach_visit *visit, void *context)
{
    const qs_grid *grid = &problem->grid;
    bool plain = !grid->mask && !grid->right; /* all inner cells of a row are alike */
    for (uint32_t y = 0; y < grid->height; y++) {
        for (uint32_t x = 0, count; x < grid->width; x += count) {
            count = plain && x == 1 && grid->width > 2 ? grid->width - 2 : 1;
            if (qs_is_site(grid, x, y)) {
                visit_cell(problem, x, y, count, visit, context);
            }
        }
    }
}

void qs_reach_visit_all(const qs_problem *problem, int64_t *sums, qs_reach_visit *visit,
                        void *context)
{
    if (problem->grid.width > 0) {
        visit_grid(problem, visit, context);
        return;
    }
    memset(sums, 0, 2 * sizeof *sums * problem->sites);
    for (size_t e = 0; e < problem->edge_count; e++) {
        const qs_edge *edge = &problem->edges[e];
        sums[2 * (size_t)edge->first] += edge->weight;
        sums[2 * (size_t)edge->second + 1] += edge->weight;
    }
    for (uint32_t p = 0; p < problem->sites; p++) {
        visit(context, 1, sums[2 * (size_t)p], sums[2 * (size_t)p + 1]);
    }
}
