#include "../../include/qstereo/overlap.h"

#include <stdbool.h>
#include <string.h>

#include "../base/arena.h"
#include "../base/minmax.h"

enum { FULL_OVERLAP = 400, UNITS = 100 };

/* V: only two kept boxes cost something. */
static const int32_t both_kept[4] = {0, 0, 0, 1};

typedef struct chooser {
    int32_t *costs; /* drop and keep of each box */
    qs_edge *edges;
} chooser;

static chooser lay_out(qs_arena *arena, uint32_t count, size_t edges)
{
    chooser c;
    c.costs = qs_arena_take(arena, 2 * (uint64_t)count, sizeof *c.costs);
    c.edges = qs_arena_take(arena, edges, sizeof *c.edges);
    return c;
}

/* How much of two spans is common, below 0 if they are apart. */
static int64_t common(int32_t a, int32_t a_size, int32_t b, int32_t b_size)
{
    int64_t a_end = (int64_t)a + a_size, b_end = (int64_t)b + b_size;
    return qs_min_i64(a_end, b_end) - qs_max_i64(a, b);
}

/* What it costs to keep both; 0 = nothing, or the boxes hardly meet. Areas are below 2^53. */
static int32_t overlap_cost(const qs_box *a, const qs_box *b)
{
    int64_t width = common(a->x, a->width, b->x, b->width),
            height = common(a->y, a->height, b->y, b->height);
    if (a->picture != b->picture || width <= 0 || height <= 0) {
        return 0;
    }
    int64_t shared = width * height;
    int64_t covered = (int64_t)a->width * a->height + (int64_t)b->width * b->height - shared;
    return 10 * shared > covered ? (int32_t)((2 * FULL_OVERLAP * shared + covered) / (2 * covered))
                                 : 0;
}

/* Writes the edges, in order, if there is room. Returns how many there are. */
static size_t find_edges(const qs_box *boxes, uint32_t count, qs_edge *edges, size_t room)
{
    size_t found = 0;
    for (uint32_t p = 0; p < count; p++) {
        for (uint32_t q = p + 1; q < count; q++) {
            int32_t cost = overlap_cost(&boxes[p], &boxes[q]);
            if (cost > 0 && found < room) {
                edges[found] = (qs_edge){p, q, cost};
            }
            found += cost > 0;
        }
    }
    return found;
}

static bool in_range(int32_t value, int32_t least, int32_t most)
{
    return value >= least && value <= most;
}

static bool boxes_in_range(const qs_box *boxes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const qs_box *box = &boxes[i];
        if (!in_range(box->x, -QS_BOX_PLACE_MAX, QS_BOX_PLACE_MAX) ||
            !in_range(box->y, -QS_BOX_PLACE_MAX, QS_BOX_PLACE_MAX) ||
            !in_range(box->width, 1, QS_BOX_PLACE_MAX) ||
            !in_range(box->height, 1, QS_BOX_PLACE_MAX) ||
            !in_range(box->score, -QS_BOX_SCORE_MAX, QS_BOX_SCORE_MAX)) {
            return false;
        }
    }
    return count > 0;
}

size_t qs_overlap_workspace(const qs_box *boxes, uint32_t count)
{
    qs_arena arena = {0};
    if (!boxes_in_range(boxes, count)) {
        return SIZE_MAX;
    }
    (void)lay_out(&arena, count, find_edges(boxes, count, NULL, 0));
    return qs_arena_size(&arena);
}

qs_status qs_overlap_problem(const qs_box *boxes, uint32_t count, void *workspace,
                             size_t workspace_size, qs_problem *problem)
{
    if (!boxes || !workspace || !problem || !boxes_in_range(boxes, count)) {
        return QS_E_ARGUMENT;
    }
    size_t edges = find_edges(boxes, count, NULL, 0);
    qs_arena arena = {.base = workspace};
    chooser c = lay_out(&arena, count, edges);
    if (workspace_size < qs_arena_size(&arena)) {
        return QS_E_WORKSPACE;
    }
    for (uint32_t i = 0; i < count; i++) {
        c.costs[2 * i] = 0;
        c.costs[2 * i + 1] = -boxes[i].score;
    }
    (void)find_edges(boxes, count, c.edges, edges);
    qs_problem made = {
        .sites = count,
        .labels = 2,
        .scale = UNITS,
        .pairwise = {QS_TABLE, 0, both_kept},
        .edges = c.edges,
        .edge_count = edges,
        .costs = c.costs,
        .meaning = {.kind = QS_MEANS_KEEP},
    };
    qs_status status = qs_problem_check(&made);
    if (status == QS_OK) {
        *problem = made;
    }
    return status;
}
