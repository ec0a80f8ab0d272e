#include "../../include/qstereo/matching.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"
#include "match_term.h"
#include "window.h"

/* Costs are summed for TILE pixels at a time, label by label, so that the least cost of each pixel
 * is the minimum of some rows. Then they are turned, to stand pixel by pixel. */
enum { TILE = QS_MATCH_TILE, PARTS = 2 };

#include "turn.h"

typedef struct matcher {
    qs_matching matching;
    qs_match_needs needs;
    uint32_t x, y, width, height, labels; /* of the grid */
    size_t rows_read; /* 1 + the row of the pictures that these hold; 0 = none */
    bool packed; /* the words of these rows have been made */
    qs_match_row left, right[PARTS]; /* right[1] holds the samples between pixels */
    uint16_t *sums; /* labels x TILE; where costs fit bytes they stand here as bytes */
    int32_t *edges_right, *edges_down; /* NULL = all edges have the same weight */
} matcher;

static bool is_window(const qs_match_term *term)
{
    bool odd = term->width % 2 == 1 && term->height % 2 == 1;
    return odd && term->width <= QS_CENSUS_ROWS && term->height <= QS_CENSUS_ROWS &&
           term->width * term->height > 1;
}

static bool is_term(const qs_match_term *term)
{
    bool census = term->cost == QS_MATCH_CENSUS;
    return (unsigned)term->cost <= QS_MATCH_CENSUS && term->weight >= 1 && term->weight <= 255 &&
           (census ? is_window(term) : term->width == 0 && term->height == 0);
}

/* The largest part of theta that a term can be. */
static uint32_t most_of(const qs_match_term *term)
{
    uint32_t most = qs_match_term_most(term);
    return term->weight * (term->truncation > 0 ? qs_min_u32(most, term->truncation) : most);
}

/* What a match outside the right picture costs. */
static uint32_t outside_cost(const qs_matching *matching)
{
    const qs_match_term *first = &matching->terms[0];
    return first->weight * first->truncation;
}

uint32_t qs_matching_most(const qs_matching *matching)
{
    uint32_t most = 0;
    for (unsigned i = 0; i < matching->term_count && i < QS_MATCH_TERMS; i++) {
        if (!is_term(&matching->terms[i])) {
            return 0;
        }
        most += most_of(&matching->terms[i]);
    }
    return matching->border == QS_BORDER_KEEP ? qs_max_u32(most, outside_cost(matching)) : most;
}

static bool is_border(const qs_matching *matching)
{
    uint32_t truncation = matching->terms[0].truncation;
    return matching->border == QS_BORDER_LEAVE_OUT ||
           (matching->border == QS_BORDER_KEEP && truncation > 0 && truncation <= UINT16_MAX);
}

/* Two terms of census share one window. */
static bool windows_agree(const qs_matching *matching)
{
    const qs_match_term *a = &matching->terms[0], *b = &matching->terms[1];
    return matching->term_count < 2 || a->cost != QS_MATCH_CENSUS || b->cost != QS_MATCH_CENSUS ||
           (a->width == b->width && a->height == b->height);
}

static bool is_matching(const qs_matching *matching)
{
    if (!matching || !qs_image_is_valid(&matching->left) || !qs_image_is_valid(&matching->right) ||
        matching->term_count < 1 || matching->term_count > QS_MATCH_TERMS || !is_border(matching) ||
        !windows_agree(matching)) {
        return false;
    }
    uint32_t most = qs_matching_most(matching);
    bool contrast = matching->contrast_below == 0 ||
                    (matching->contrast_below <= 256 && matching->contrast_times >= 1);
    return most >= 1 && most <= UINT16_MAX && matching->parts >= 1 && matching->parts <= PARTS &&
           matching->disparity_min <= matching->disparity_max &&
           matching->disparity_min > INT32_MIN && matching->scale >= 1 && matching->weight >= 0 &&
           matching->copies <= QS_MATCH_COPIES && contrast;
}

static qs_match_needs needs_of(const qs_matching *matching)
{
    qs_match_needs needs = {.wide = qs_lanes_avx2()};
    for (unsigned i = 0; i < matching->term_count && i < QS_MATCH_TERMS; i++) {
        const qs_match_term *term = &matching->terms[i];
        needs.range = needs.range || term->cost == QS_MATCH_BT;
        if (term->cost == QS_MATCH_CENSUS && !needs.census) {
            needs.census = true;
            needs.width = term->width;
            needs.height = term->height;
        }
    }
    return needs;
}

static uint32_t labels_of(const qs_matching *matching)
{
    return (uint32_t)matching->disparity_max - (uint32_t)matching->disparity_min + 1;
}

/* The whole pixels of a disparity in parts, rounded down. */
static int64_t whole_of(const qs_matching *matching, int64_t disparity)
{
    int64_t parts = matching->parts;
    return (disparity - (disparity < 0 ? parts - 1 : 0)) / parts;
}

/* Pixels that the largest disparity reaches over, to the left. */
static uint32_t reach_of(const qs_matching *matching)
{
    int64_t up = -whole_of(matching, -(int64_t)matching->disparity_max);
    return up > 0 ? (uint32_t)up : 0;
}

/* Pixels that the least disparity reaches over, to the right. */
static uint32_t reach_right_of(const qs_matching *matching)
{
    int64_t least = whole_of(matching, matching->disparity_min);
    return least < 0 ? (uint32_t)-least : 0;
}

static uint32_t copies_of(const qs_matching *matching)
{
    return qs_max_u32(matching->copies, 1);
}

/* What a copy needs for itself. */
static void take_copy(qs_arena *arena, matcher *plan)
{
    const qs_matching *matching = &plan->matching;
    size_t across = matching->left.width, pad = qs_min_u32(reach_of(matching), (uint32_t)across);
    size_t behind = TILE + qs_min_u32(reach_right_of(matching), (uint32_t)across);
    plan->left = qs_match_row_take(arena, &plan->needs, across, 0, TILE);
    for (uint32_t i = 0; i < matching->parts && i < PARTS; i++) {
        plan->right[i] = qs_match_row_take(arena, &plan->needs, across, pad, behind);
    }
    plan->sums = qs_arena_take(arena, plan->labels, TILE * sizeof *plan->sums);
}

/* The copies, one behind the other. */
static matcher *take(qs_arena *arena, const qs_matching *matching, const qs_grid *grid)
{
    uint32_t copies = copies_of(matching);
    matcher plan = {.matching = *matching,
                    .needs = needs_of(matching),
                    .width = grid->width,
                    .height = grid->height,
                    .labels = labels_of(matching)};
    matcher *made = qs_arena_take(arena, copies, sizeof *made);
    if (matching->contrast_below > 0) {
        uint64_t cells = (uint64_t)grid->width * grid->height;
        plan.edges_right = qs_arena_take(arena, cells, sizeof *plan.edges_right);
        plan.edges_down = qs_arena_take(arena, cells, sizeof *plan.edges_down);
    }
    for (uint32_t i = 0; i < copies; i++) {
        take_copy(arena, &plan);
        if (made) {
            made[i] = plan;
        }
    }
    return made;
}

/* The columns whose matches for a label lie in the right picture. */
static qs_columns matched_by(const qs_matching *matching, int64_t label)
{
    return (qs_columns){-whole_of(matching, -label),
                        (int64_t)matching->left.width + whole_of(matching, label)};
}

/* The window, without the pixels that the border leaves out. */
static qs_status place_grid(const qs_matching *of, qs_problem *problem)
{
    qs_columns placed = {0, (int64_t)of->left.width};
    if (of->border == QS_BORDER_LEAVE_OUT) {
        placed = (qs_columns){matched_by(of, of->disparity_max).begin,
                              matched_by(of, of->disparity_min).end};
    }
    problem->frame.first = of->disparity_min;
    return qs_window_place(&of->left, &of->right, of->x, of->y, of->width, of->height, placed,
                           problem);
}

size_t qs_matching_workspace(const qs_matching *matching)
{
    qs_arena count = {NULL, 0, false};
    qs_problem placed;
    if (!is_matching(matching) || place_grid(matching, &placed) != QS_OK) {
        return 0;
    }
    (void)take(&count, matching, &placed.grid);
    return qs_arena_size(&count);
}

/* Matches before the first and behind the last pixel of the right picture cost the same. */
static void price_outside(const matcher *m, int64_t label, uint32_t x, uint32_t count,
                          uint16_t *sum)
{
    const qs_matching *matching = &m->matching;
    qs_columns matched = matched_by(matching, label);
    if (x >= matched.begin && (int64_t)x + count <= matched.end) {
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (x + i < matched.begin || x + i >= matched.end) {
            sum[i] = (uint16_t)outside_cost(matching);
        }
    }
}

/* Where in a row's arrays the matches of a tile begin. Those far outside have no samples; they are
 * priced apart. */
static size_t matches_at(const qs_match_row *right, int64_t x, int64_t disparity)
{
    int64_t at = (int64_t)right->pad + x - disparity, last = (int64_t)right->length - TILE;
    return (size_t)(at < 0 ? 0 : at < last ? at : last);
}

/* The sums of a tile that begins at column x of the picture, for one label. */
static void sum_label(const matcher *m, uint32_t d, uint32_t x, uint32_t count, uint16_t *sum)
{
    const qs_matching *matching = &m->matching;
    int64_t label = (int64_t)matching->disparity_min + d, pixels = whole_of(matching, label);
    const qs_match_row *right = &m->right[label - pixels * matching->parts];
    size_t from = matches_at(right, x, pixels);
    memset(sum, 0, TILE * sizeof *sum);
    for (unsigned i = 0; i < matching->term_count; i++) {
        const qs_match_term *term = &matching->terms[i];
        if (m->needs.wide) {
            qs_match_term_add_avx2(term, &m->left, x, right, from, sum);
        } else {
            qs_match_term_add(term, &m->left, x, right, from, sum);
        }
    }
    price_outside(m, label, x, count, sum);
}

static void tile_of_bytes(const matcher *m, uint32_t x, uint32_t count, uint8_t *costs,
                          int32_t *least)
{
    uint8_t tile_least[TILE], *planes = (uint8_t *)m->sums;
    uint16_t sum[TILE];
    memset(tile_least, UINT8_MAX, sizeof tile_least);
    for (uint32_t d = 0; d < m->labels; d++) {
        uint8_t *plane = planes + (size_t)TILE * d;
        sum_label(m, d, m->x + x, count, sum);
        for (int i = 0; i < TILE; i++) {
            plane[i] = (uint8_t)sum[i];
            tile_least[i] = plane[i] < tile_least[i] ? plane[i] : tile_least[i];
        }
    }
    qs_turn(planes, m->labels, tile_least, count, costs);
    for (uint32_t i = 0; i < count; i++) {
        least[i] = tile_least[i];
    }
}

static void tile_of_words(const matcher *m, uint32_t x, uint32_t count, uint32_t *costs,
                          int32_t *least)
{
    uint16_t tile_least[TILE];
    uint32_t scale = m->matching.scale;
    memset(tile_least, UINT8_MAX, sizeof tile_least);
    for (uint32_t d = 0; d < m->labels; d++) {
        uint16_t *sum = m->sums + (size_t)TILE * d;
        sum_label(m, d, m->x + x, count, sum);
        for (int i = 0; i < TILE; i++) {
            tile_least[i] = sum[i] < tile_least[i] ? sum[i] : tile_least[i];
        }
    }
    for (uint32_t i = 0; i < count; i++, costs += m->labels) {
        const uint16_t *sum = m->sums + i;
        for (uint32_t d = 0; d < m->labels; d++) {
            costs[d] = (uint32_t)(sum[(size_t)TILE * d] - tile_least[i]) * scale;
        }
        least[i] = (int32_t)(tile_least[i] * scale);
    }
}

static bool fits_bytes(const qs_matching *matching)
{
    return matching->scale == 1 && qs_matching_most(matching) <= UINT8_MAX;
}

/* Reads the rows of both pictures, unless they are those that were read last. */
static void read_row(matcher *m, uint32_t row)
{
    const qs_matching *matching = &m->matching;
    size_t y = (size_t)m->y + row;
    if (m->rows_read == y + 1) {
        return;
    }
    m->rows_read = y + 1;
    m->packed = false;
    qs_match_row_read(&m->left, &m->needs, &matching->left, y, false);
    for (uint32_t i = 0; i < matching->parts; i++) {
        qs_match_row_read(&m->right[i], &m->needs, &matching->right, y, i == 1);
    }
}

/* Makes the words of the rows that were read. */
static void pack_rows(matcher *m)
{
    if (m->packed) {
        return;
    }
    qs_match_row_pack(&m->left);
    for (uint32_t i = 0; i < m->matching.parts; i++) {
        qs_match_row_pack(&m->right[i]);
    }
    m->packed = true;
}

/* Where the match of a label at column x of the picture is. Returns false if it is outside. */
static bool place_match(const qs_matching *matching, int64_t x, int64_t label, size_t pad,
                        qs_match_place *place)
{
    int64_t part = matching->parts > 1 ? label & 1 : 0;
    int64_t at = x - (matching->parts > 1 ? (label - part) / PARTS : label);
    bool inside = at >= part && at < (int64_t)matching->right.width;
    *place = (qs_match_place){(uint32_t)part, (uint32_t)(inside ? at : 0) + (uint32_t)pad};
    return inside;
}

/* The costs of up to TILE pixels from column x of the picture. */
static void pick_tile(const matcher *m, uint32_t x, uint32_t count, const uint16_t *labels,
                      int32_t *costs)
{
    const qs_matching *matching = &m->matching;
    qs_match_place places[TILE];
    uint32_t sum[TILE] = {0};
    bool inside[TILE];
    for (uint32_t i = 0; i < count; i++) {
        int64_t label = (int64_t)matching->disparity_min + labels[i];
        inside[i] = place_match(matching, (int64_t)x + i, label, m->right[0].pad, &places[i]);
    }
    for (unsigned i = 0; i < matching->term_count; i++) {
        qs_match_term_pick(&matching->terms[i], &m->left, x, m->right, places, count, sum);
    }
    for (uint32_t i = 0; i < count; i++) {
        costs[i] = (int32_t)((inside[i] ? sum[i] : outside_cost(matching)) * matching->scale);
    }
}

static void pick_row(void *context, uint32_t row, const uint16_t *labels, int32_t *costs)
{
    matcher *m = context;
    read_row(m, row);
    pack_rows(m);
    for (uint32_t x = 0; x < m->width; x += TILE) {
        pick_tile(m, m->x + x, qs_min_u32(m->width - x, TILE), labels + x, costs + x);
    }
}

static void cost_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    matcher *m = context;
    bool bytes = fits_bytes(&m->matching);
    read_row(m, row);
    for (uint32_t x = 0; x < m->width; x += TILE) {
        uint32_t count = qs_min_u32(m->width - x, TILE);
        size_t at = (size_t)x * m->labels;
        if (bytes) {
            tile_of_bytes(m, x, count, (uint8_t *)costs + at, least + x);
        } else {
            tile_of_words(m, x, count, (uint32_t *)costs + at, least + x);
        }
    }
}

static int32_t edge_weight(const qs_matching *matching, uint8_t a, uint8_t b)
{
    uint32_t off = a > b ? (uint32_t)(a - b) : (uint32_t)(b - a);
    return off < matching->contrast_below ? matching->weight * (int32_t)matching->contrast_times
                                          : matching->weight;
}

/* The weights of all edges; those of the last column and row are not used. */
static void weigh_edges(const matcher *m)
{
    const qs_image *left = &m->matching.left;
    for (uint32_t y = 0; y < m->height; y++) {
        const uint8_t *row = left->pixels + ((size_t)m->y + y) * left->stride + m->x;
        const uint8_t *below = y + 1 < m->height ? row + left->stride : row;
        int32_t *to_right = m->edges_right + (size_t)y * m->width;
        int32_t *to_below = m->edges_down + (size_t)y * m->width;
        for (uint32_t x = 0; x < m->width; x++) {
            to_right[x] = edge_weight(&m->matching, row[x], row[x + 1 < m->width ? x + 1 : x]);
            to_below[x] = edge_weight(&m->matching, row[x], below[x]);
        }
    }
}

static qs_status check_numbers(const qs_matching *matching)
{
    uint64_t cost = (uint64_t)qs_matching_most(matching) * matching->scale;
    uint64_t times = matching->contrast_below > 0 ? matching->contrast_times : 1;
    uint64_t weight = (uint64_t)matching->weight * times;
    return cost <= INT32_MAX && weight <= INT32_MAX ? QS_OK : QS_E_OVERFLOW;
}

/* What the problem says of itself before its costs and weights have a place. */
static qs_status plan_problem(const qs_matching *matching, qs_problem *planned)
{
    if ((int64_t)matching->disparity_max - matching->disparity_min >= QS_LABELS_MAX) {
        return QS_E_LIMIT;
    }
    qs_status status = check_numbers(matching);
    *planned = (qs_problem){
        .labels = labels_of(matching),
        .scale = matching->scale,
        .weight = matching->weight,
        .meaning = {.unit = matching->parts > 1 ? matching->parts : 0},
    };
    return status == QS_OK ? place_grid(matching, planned) : status;
}

qs_status qs_matching_problem(const qs_matching *matching, void *workspace, size_t workspace_size,
                              qs_problem *problem)
{
    qs_problem made;
    if (!is_matching(matching) || !workspace || !problem) {
        return QS_E_ARGUMENT;
    }
    qs_status status = plan_problem(matching, &made);
    if (status != QS_OK) {
        return status;
    }
    if (workspace_size < qs_matching_workspace(matching)) {
        return QS_E_WORKSPACE;
    }
    qs_arena arena = {workspace, 0, false};
    matcher *m = take(&arena, matching, &made.grid);
    for (uint32_t i = 0; i < copies_of(matching); i++) {
        m[i].x = made.frame.x;
        m[i].y = made.frame.y;
    }
    made.source = (qs_cost_source){.row = cost_row,
                                   .context = m,
                                   .bytes = fits_bytes(matching) ? 1 : 4,
                                   .pick = pick_row,
                                   .copies = (uint8_t)matching->copies,
                                   .stride = sizeof *m};
    made.grid.right = m->edges_right;
    made.grid.down = m->edges_down;
    if (m->edges_right) {
        weigh_edges(m);
    }
    status = qs_problem_check(&made);
    if (status == QS_OK) {
        *problem = made;
    }
    return status;
}
