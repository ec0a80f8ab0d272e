/* Larger grids for the tests of reductions, and their least energies. */
#ifndef WIDE_GRID_H
#define WIDE_GRID_H

#include "tiny.h"

#include <string.h>

/* Grids with too many labellings to try all, and with enough labels for AVX2. They have three
 * columns only, so that the frontier, three sites in a row, has few labellings. */
enum { COLUMNS = 3, ROWS = 5, WIDE_LABELS = 9, FRONTIER = WIDE_LABELS * WIDE_LABELS * WIDE_LABELS };

typedef struct wide_grid {
    qs_model model;
    int32_t unary[COLUMNS * ROWS * WIDE_LABELS], right[COLUMNS * ROWS], down[COLUMNS * ROWS];
} wide_grid;

static void make_wide(wide_grid *g, uint64_t *state)
{
    uint32_t kind = tiny_random(state, 3);
    g->model = (qs_model){.sites = COLUMNS * ROWS,
                          .labels = WIDE_LABELS,
                          .constant = 5,
                          .unary = g->unary,
                          .pairwise_max = 1};
    g->model.width = COLUMNS;
    g->model.height = ROWS;
    g->model.right = g->right;
    g->model.down = g->down;
    for (uint32_t p = 0; p < g->model.sites; p++) {
        g->right[p] = (p + 1) % COLUMNS != 0 ? 3 + (int32_t)tiny_random(state, 6) : 0;
        g->down[p] = p + COLUMNS < g->model.sites ? 3 + (int32_t)tiny_random(state, 6) : 0;
        for (uint32_t d = 0; d < WIDE_LABELS; d++) {
            g->unary[p * WIDE_LABELS + d] = (int32_t)tiny_random(state, kind == 0 ? 3 : 25);
        }
        g->unary[p * WIDE_LABELS + tiny_random(state, WIDE_LABELS)] = 0;
    }
}

/* The least energy of all labellings with a label at a site; of all labellings if `site` is the
 * number of sites. It goes from site to site. For each labelling of the last three sites, `least`
 * is the least energy of all sites so far. */
static int64_t least_with(const wide_grid *g, uint32_t site, uint32_t label)
{
    static int64_t least[2][FRONTIER];
    memset(least[0], 0, sizeof least[0]);
    for (uint32_t p = 0; p < g->model.sites; p++) {
        int64_t *from = least[p % 2], *to = least[1 - p % 2];
        for (uint32_t i = 0; i < FRONTIER; i++) {
            to[i] = INT64_MAX / 2;
        }
        for (uint32_t i = 0; i < FRONTIER; i++) {
            /* The digits of i: the site above, the one after it, the one to the left. */
            uint32_t above = i / WIDE_LABELS / WIDE_LABELS, before = i % WIDE_LABELS,
                     rest = i % (WIDE_LABELS * WIDE_LABELS);
            for (uint32_t d = 0; d < WIDE_LABELS; d++) {
                int64_t cost = from[i] + g->unary[p * WIDE_LABELS + d] +
                               (p % COLUMNS > 0 && before != d ? g->right[p - 1] : 0) +
                               (p >= COLUMNS && above != d ? g->down[p - COLUMNS] : 0) +
                               (p == site && d != label ? INT32_MAX : 0);
                int64_t *there = &to[rest * WIDE_LABELS + d];
                *there = cost < *there ? cost : *there;
            }
        }
    }
    int64_t all = INT64_MAX;
    for (uint32_t i = 0; i < FRONTIER; i++) {
        all = least[g->model.sites % 2][i] < all ? least[g->model.sites % 2][i] : all;
    }
    return all + g->model.constant;
}

#endif
