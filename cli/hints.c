#include "hints.h"

#include <inttypes.h>

#include "text/fail.h"

/* The sum of the cheapest differences of a row: what its pixels cost where nothing is smooth. */
static uint64_t row_cost(const qs_image *left, const qs_image *right, const qs_matching *stereo,
                         size_t y)
{
    const uint8_t *l = left->pixels + y * left->stride, *r = right->pixels + y * right->stride;
    uint64_t cost = 0;
    int64_t width = (int64_t)left->width, from = stereo->disparity_max / (int32_t)stereo->parts,
            to = stereo->disparity_min / (int32_t)stereo->parts;
    for (int64_t x = from > 0 ? from : 0; x < (to < 0 ? width + to : width); x++) {
        int best = UINT8_MAX;
        for (int64_t d = to; d <= from; d++) {
            int off = l[x] < r[x - d] ? r[x - d] - l[x] : l[x] - r[x - d];
            best = off < best ? off : best;
        }
        cost += (uint64_t)best;
    }
    return cost;
}

void hint_swapped(const pair *of)
{
    enum { ROWS = 64, FAR_LOWER = 2 };
    const qs_matching *stereo = &of->stereo;
    size_t step = stereo->left.height / ROWS + 1;
    uint64_t given = 0, swapped = 0;
    for (size_t y = 0; y < stereo->left.height; y += step) {
        given += row_cost(&stereo->left, &stereo->right, stereo, y);
        swapped += row_cost(&stereo->right, &stereo->left, stereo, y);
    }
    if (swapped * FAR_LOWER < given) {
        warn(input_name(of->left),
             "the other order of the pictures fits far better: are left and right swapped?");
    }
}

void hint_truth(const pair *of, const true_map *truth)
{
    enum { MANY = 10 };
    const qs_map *map = &truth->map;
    int32_t most = of->stereo.disparity_max / (int32_t)of->stereo.parts;
    uint64_t known = 0, beyond = 0;
    for (size_t i = 0; i < map->width * map->height; i++) {
        if (map->values[i] != QS_NO_DISPARITY) {
            known++;
            beyond += map->values[i] > ((int64_t)most + 1) * map->scale;
        }
    }
    if (beyond * MANY > known) {
        warn(truth->name,
             "%.3g %% of its disparities are above %" PRId32 ", the largest of --disparity: raise "
             "it, or is --truth-scale wrong?",
             100.0 * (double)beyond / (double)known, most);
    }
}

void hint_range(const pair *of, const pixel_map *map)
{
    uint64_t sites = 0, largest = 0;
    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
        sites += map->disparities[i] != QS_NO_DISPARITY;
        largest += map->disparities[i] == map->most;
    }
    if (map->most > map->least && 2 * largest > sites) {
        warn(input_name(of->left),
             "%.3g %% of the pixels have the largest disparity, %" PRId32
             ": raise the MAX of --disparity",
             100.0 * (double)largest / (double)sites, map->most / (int32_t)map->unit);
    }
}
