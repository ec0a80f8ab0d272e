/* Costs of one byte that were computed label by label, put pixel by pixel. The file that includes
 * this has a constant TILE, the number of pixels of a plane. */
#ifndef QS_TURN_H
#define QS_TURN_H

#include <string.h>

#include "../base/minmax.h"

enum { QS_GROUP = 16, QS_HALF = 8 };

/* Puts QS_GROUP planes, or QS_HALF of them, less the least, side by side for each pixel. There are
 * two functions because the compiler makes fast code of each only if it knows how many planes. */
static void qs_interleave_group(const uint8_t *restrict planes, const uint8_t *restrict least,
                                uint8_t *restrict out)
{
    for (int i = 0; i < TILE; i++) {
        for (int d = 0; d < QS_GROUP; d++) {
            out[QS_GROUP * i + d] = (uint8_t)(planes[TILE * d + i] - least[i]);
        }
    }
}

static void qs_interleave_half(const uint8_t *restrict planes, const uint8_t *restrict least,
                               uint8_t *restrict out)
{
    for (int i = 0; i < TILE; i++) {
        for (int d = 0; d < QS_HALF; d++) {
            out[QS_HALF * i + d] = (uint8_t)(planes[TILE * d + i] - least[i]);
        }
    }
}

/* Copies the labels that have been put side by side to their place in each pixel. */
static void qs_place(const uint8_t *together, size_t size, uint8_t *costs, size_t labels,
                     uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        memcpy(costs + i * labels, together + i * size, size);
    }
}

/* Turns planes (label by label) into costs (pixel by pixel), several labels at a time. The last
 * group of labels may overlap the one before.
 *
 * planes  labels x TILE
 * least   what is subtracted from the costs of each pixel
 * count   of the pixels that are wanted, up to TILE */
static void qs_turn(const uint8_t *planes, uint32_t labels, const uint8_t *least, uint32_t count,
                    uint8_t *costs)
{
    uint8_t together[TILE * QS_GROUP];
    uint32_t d = 0;
    if (labels == QS_GROUP && count == TILE) {
        qs_interleave_group(planes, least, costs);
        return;
    }
    for (; d + QS_GROUP <= labels; d += QS_GROUP) {
        qs_interleave_group(planes + (size_t)TILE * d, least, together);
        qs_place(together, QS_GROUP, costs + d, labels, count);
    }
    while (d < labels && labels >= QS_HALF) {
        d = qs_min_u32(d, labels - QS_HALF);
        qs_interleave_half(planes + (size_t)TILE * d, least, together);
        qs_place(together, QS_HALF, costs + d, labels, count);
        d += QS_HALF;
    }
    for (; d < labels; d++) {
        for (uint32_t i = 0; i < count; i++) {
            costs[(size_t)i * labels + d] = (uint8_t)(planes[(size_t)TILE * d + i] - least[i]);
        }
    }
}

#endif
