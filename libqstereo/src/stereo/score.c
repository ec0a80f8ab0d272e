#include "../../include/qstereo/score.h"

#include <stdbool.h>

uint64_t qs_disparity_hold(uint32_t disparity, uint32_t scale)
{
    return disparity == 0 ? 1 : (uint64_t)disparity * scale;
}

int32_t qs_disparity_read(uint32_t held, uint32_t scale)
{
    if (held == 0 || held > INT32_MAX) {
        return QS_NO_DISPARITY;
    }
    return held == 1 && scale > 1 ? 0 : (int32_t)held;
}

/* Adds e^2 to the 128-bit sum. |e| < 2^49, so its square has 98 bits. */
static void add_square(qs_score *score, uint64_t e)
{
    uint64_t high = e >> 32, low = e & UINT32_MAX;
    uint64_t middle = 2 * high * low; /* < 2^51 */
    uint64_t sum = score->squares_low + low * low;
    score->squares_high += high * high + (middle >> 32) + (sum < score->squares_low);
    score->squares_low = sum + (middle << 32);
    score->squares_high += score->squares_low < sum;
}

static bool is_map(const qs_map *map)
{
    return map && map->values && map->scale >= 1 && map->scale <= 65536;
}

qs_status qs_score_map(const qs_map *map, const qs_map *truth, qs_score *score)
{
    if (!is_map(map) || !is_map(truth) || !score) {
        return QS_E_ARGUMENT;
    }
    if (map->width != truth->width || map->height != truth->height) {
        return QS_E_GEOMETRY;
    }
    qs_score s = {0};
    uint64_t one = (uint64_t)map->scale * truth->scale; /* a pixel, in units of e */
    for (size_t i = 0; i < map->width * map->height; i++) {
        int64_t d = map->values[i], t = truth->values[i];
        s.truths += t != QS_NO_DISPARITY;
        if (d == QS_NO_DISPARITY || t == QS_NO_DISPARITY) {
            continue;
        }
        int64_t off = d * truth->scale - t * map->scale;
        uint64_t e = (uint64_t)(off < 0 ? -off : off);
        s.pixels++;
        s.bad_half += 2 * e > one;
        s.bad_one += e > one;
        s.bad_two += e > 2 * one;
        s.d1 += e > 3 * one && 20 * (int64_t)e > (t < 0 ? -t : t) * map->scale;
        s.sum_low += e;
        s.sum_high += s.sum_low < e;
        add_square(&s, e);
    }
    *score = s;
    return QS_OK;
}
