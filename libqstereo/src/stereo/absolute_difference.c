#include "../../include/qstereo/stereo.h"

#include <stdbool.h>
#include <string.h>

#include "../base/minmax.h"
#include "window.h"

/* Costs are computed for TILE pixels at a time, label by label: so the least cost of each pixel is
 * the minimum of some rows. Then they are transposed, to stand pixel by pixel. Both stay in the
 * first cache for all usual numbers of labels. */
#ifdef QS_SMALL
enum { TILE = 4 };
#else
enum { TILE = 64 };
#endif

#include "turn.h"

typedef struct matcher {
    qs_stereo stereo;
    uint32_t x, y, width, labels; /* of the grid */
    uint8_t *planes; /* labels x TILE */
} matcher;

static uint32_t labels_of(const qs_stereo *stereo)
{
    return (uint32_t)stereo->disparity_max - (uint32_t)stereo->disparity_min + 1;
}

size_t qs_stereo_workspace(const qs_stereo *stereo)
{
    return sizeof(matcher) + (size_t)TILE * labels_of(stereo);
}

/* |left - right| of a tile for one label, and the least so far. It is the larger less the smaller,
 * so that all instructions work on bytes. */
static void ad_plane(const uint8_t *restrict left, const uint8_t *restrict right,
                     uint8_t *restrict plane, uint8_t *restrict least)
{
    for (int i = 0; i < TILE; i++) {
        uint8_t a = left[i], b = right[i];
        uint8_t apart = (uint8_t)((a > b ? a : b) - (a < b ? a : b));
        plane[i] = apart;
        least[i] = apart < least[i] ? apart : least[i];
    }
}

/* The costs of `count` pixels of a row from grid column x on, in units of grey. */
static void ad_tile(const matcher *m, uint32_t row, uint32_t x, uint32_t count, uint8_t *costs,
                    uint8_t least[TILE])
{
    const qs_stereo *stereo = &m->stereo;
    size_t y = (size_t)m->y + row, at = (size_t)m->x + x;
    const uint8_t *left = stereo->left.pixels + y * stereo->left.stride + at;
    const uint8_t *right = stereo->right.pixels + y * stereo->right.stride +
                           (size_t)((int64_t)at - stereo->disparity_min);
    uint8_t left_tile[TILE] = {0}, right_tile[TILE] = {0};
    memset(least, UINT8_MAX, TILE);
    if (count < TILE) { /* nothing is read beyond the window */
        left = memcpy(left_tile, left, count);
    }
    for (uint32_t d = 0; d < m->labels; d++) {
        const uint8_t *from = count < TILE ? memcpy(right_tile, right - d, count) : right - d;
        ad_plane(left, from, m->planes + (size_t)TILE * d, least);
    }
    qs_turn(m->planes, m->labels, least, count, costs);
}

static void ad_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const matcher *m = context;
    uint32_t count = qs_min_u32(m->width, TILE);
    for (uint32_t x = 0; x < m->width; x += TILE) {
        uint8_t tile_least[TILE];
        uint32_t from = qs_min_u32(x, m->width - count); /* the last may overlap the one before */
        ad_tile(m, row, from, count, (uint8_t *)costs + (size_t)from * m->labels, tile_least);
        for (uint32_t i = 0; i < count; i++) {
            least[from + i] = tile_least[i];
        }
    }
}

/* The same times the scale, in 32 bits. */
static void scaled_ad_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const matcher *m = context;
    uint32_t scale = m->stereo.scale, *wide = costs;
    size_t count = (size_t)m->width * m->labels;
    /* The bytes go into the last quarter. Widening from the front never overtakes them. */
    uint8_t *narrow = (uint8_t *)costs + 3 * count;
    ad_row(context, row, narrow, least);
    for (size_t i = 0; i < count; i++) {
        wide[i] = narrow[i] * scale;
    }
    for (uint32_t x = 0; x < m->width; x++) {
        least[x] *= (int32_t)scale;
    }
}

static bool is_stereo(const qs_stereo *stereo)
{
    return stereo && qs_image_is_valid(&stereo->left) && qs_image_is_valid(&stereo->right) &&
           stereo->cost == QS_COST_AD && stereo->disparity_min > INT32_MIN &&
           stereo->disparity_min <= stereo->disparity_max && stereo->scale >= 1 &&
           stereo->scale <= INT32_MAX / UINT8_MAX && stereo->weight >= 0;
}

/* Pixel c has all its matches where 0 <= c - disparity_max and c - disparity_min < width. */
static qs_status place_grid(const qs_stereo *of, qs_problem *problem)
{
    qs_columns matched = {of->disparity_max, (int64_t)of->left.width + of->disparity_min};
    problem->frame.first = of->disparity_min;
    return qs_window_place(&of->left, &of->right, of->x, of->y, of->width, of->height, matched,
                           problem);
}

qs_status qs_stereo_problem(const qs_stereo *stereo, void *workspace, size_t workspace_size,
                            qs_problem *problem)
{
    if (!is_stereo(stereo) || !workspace || !problem) {
        return QS_E_ARGUMENT;
    }
    if (labels_of(stereo) > QS_LABELS_MAX) {
        return QS_E_LIMIT;
    }
    if (workspace_size < qs_stereo_workspace(stereo)) {
        return QS_E_WORKSPACE;
    }
    qs_problem made = {
        .labels = labels_of(stereo), .scale = stereo->scale, .weight = stereo->weight};
    qs_status status = place_grid(stereo, &made);
    if (status != QS_OK) {
        return status;
    }
    matcher *m = workspace;
    *m = (matcher){*stereo,         made.frame.x, made.frame.y,
                   made.grid.width, made.labels,  (uint8_t *)(m + 1)};
    bool bytes = stereo->scale == 1;
    made.source = (qs_cost_source){bytes ? ad_row : scaled_ad_row, m, bytes ? 1 : 4, 0, 0, NULL};
    status = qs_problem_check(&made);
    if (status == QS_OK) {
        *problem = made;
    }
    return status;
}
