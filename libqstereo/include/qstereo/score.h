/* Disparity maps and how far they are from the truth. */
#ifndef QSTEREO_SCORE_H
#define QSTEREO_SCORE_H

#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* In integer maps 0 says "no value", so a disparity of 0 is held as 1 (after
 * KITTI's convention) and read back as 0. */
#define QS_NO_DISPARITY INT32_MIN

/* What an integer map holds for a disparity in pixels: disparity * scale, and 1
 * for 0. scale  at least 2, so that 1 means nothing else. */
uint64_t qs_disparity_hold(uint32_t disparity, uint32_t scale);

/* The reverse: the value in units of 1/scale pixel, or QS_NO_DISPARITY. With
 * scale 1 a 1 is 1 pixel. */
int32_t qs_disparity_read(uint32_t held, uint32_t scale);

/* Disparities in units of 1/scale pixel, row after row without gaps;
 * QS_NO_DISPARITY = none. */
typedef struct qs_map {
    const int32_t *values;
    size_t width, height;
    uint32_t scale; /* 1 .. 65536 */
} qs_map;

/* The paper's eq. (6) and (7) as exact integers. With e = 1 / (map.scale *
 * truth.scale) pixel: rms = e * sqrt(squares / pixels),   bad-0.5 = 100
 * bad_half / pixels,   bad-1.0 = 100 bad_one / pixels. */
typedef struct qs_score {
    uint64_t pixels; /* with a value in both maps: only these count */
    uint64_t squares_high, squares_low; /* sum of squared errors: high * 2^64 +
                                           low, in units of e^2 */
    uint64_t bad_half, bad_one; /* pixels off by more than 0.5 and 1.0 */
} qs_score;

/* Compares a map with the truth. Returns QS_OK, QS_E_ARGUMENT, or QS_E_GEOMETRY
 * (other sizes). */
QS_MUST_CHECK qs_status qs_score_map(const qs_map *map, const qs_map *truth,
                                     qs_score *score);

#ifdef __cplusplus
}
#endif

#endif
