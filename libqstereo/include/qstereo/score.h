/* Disparity maps: made from labellings, and compared with the truth. */
#ifndef QSTEREO_SCORE_H
#define QSTEREO_SCORE_H

#include "labels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* In a map of disparities: no value here. */
#define QS_NO_DISPARITY INT32_MIN

/* Places a labelling into the picture that the problem was made from.
 *
 * labels       the window, the mask, and the value of each label: those of
 *              qs_model_of_problem, or of a file (qs_qubo, labels)
 * labelling    a label of each of labels->sites, as qs_sample_decode or
 *              qs_model_sites give it
 * disparities  out: frame.picture_width x frame.picture_height values, row
 *              after row: frame.first plus the label, in pixels or in parts of
 *              one (meaning.unit);
 *              QS_NO_DISPARITY outside the window and at masked cells
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a label that there is not
 *   QS_E_GEOMETRY  the problem is not a grid, or its window leaves the picture
 *   QS_E_OVERFLOW  the largest disparity is above 2^31 - 1 */
QS_MUST_CHECK qs_status qs_map_of_labelling(const qs_labels *labels,
                                            const uint16_t *labelling,
                                            int32_t *disparities);

/* What a map of whole numbers holds for a disparity. In such maps 0 says "no
 * value", so a disparity of 0 is held as 1 (as KITTI does).
 *
 * disparity  in pixels
 * scale      at least 2, so that no other disparity is held as 1
 *
 * Returns disparity * scale, and 1 for 0. */
uint64_t qs_disparity_hold(uint32_t disparity, uint32_t scale);

/* The reverse. Returns the disparity in units of 1 / scale pixel, or
 * QS_NO_DISPARITY. With a scale of 1 a 1 is 1 pixel. */
int32_t qs_disparity_read(uint32_t held, uint32_t scale);

/* Disparities in units of 1 / scale pixel, row after row without gaps;
 * QS_NO_DISPARITY = none. */
typedef struct qs_map {
    const int32_t *values;
    size_t width, height;
    uint32_t scale; /* 1 .. 65536 */
} qs_map;

/* Errors of a map, as exact integers (Heidari, Dinneen and Delmas, eq. (6) and
 * (7)). With e = 1 / (map.scale * truth.scale) pixel:
 *     rms     = e * sqrt(squares / pixels)
 *     bad-0.5 = 100 bad_half / pixels
 *     bad-1.0 = 100 bad_one / pixels
 *     bad-2.0 and D1 likewise
 *     average = e * sum / pixels
 *     density = 100 pixels / truths */
typedef struct qs_score {
    uint64_t pixels; /* with a value in both maps: only these count */
    uint64_t squares_high, squares_low; /* sum of squared errors in units of
                                           e^2: high * 2^64 + low */
    uint64_t bad_half, bad_one; /* pixels off by more than 0.5 and 1.0 */
    uint64_t bad_two; /* off by more than 2.0 */
    uint64_t sum_high, sum_low; /* sum of absolute errors in units of e:
                                   high * 2^64 + low */
    uint64_t d1; /* off by more than 3 pixels and by more than a twentieth of
                    the truth: KITTI's D1 (Menze and Geiger 2015) */
    uint64_t truths; /* pixels with a value in the truth */
} qs_score;

/* Compares a map with the truth.
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a scale out of range
 *   QS_E_GEOMETRY  the two are not of the same size */
QS_MUST_CHECK qs_status qs_score_map(const qs_map *map, const qs_map *truth,
                                     qs_score *score);

#ifdef __cplusplus
}
#endif

#endif
