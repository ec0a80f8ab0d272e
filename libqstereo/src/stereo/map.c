#include "../../include/qstereo/score.h"

#include <stdbool.h>

static bool is_inside(const qs_labels *labels)
{
    const qs_frame *frame = &labels->frame;
    return frame->x <= frame->picture_width && labels->width <= frame->picture_width - frame->x &&
           frame->y <= frame->picture_height && labels->height <= frame->picture_height - frame->y;
}

static bool is_site(const uint8_t *mask, size_t cell)
{
    return !mask || (mask[cell / 8] >> cell % 8 & 1) != 0;
}

static bool labels_exist(const qs_labels *labels, const uint16_t *labelling)
{
    for (uint32_t site = 0; site < labels->sites; site++) {
        if (labelling[site] >= labels->labels) {
            return false;
        }
    }
    return true;
}

static void place(const qs_labels *labels, const uint16_t *labelling, int32_t *disparities)
{
    const qs_frame *frame = &labels->frame;
    size_t pixels = (size_t)frame->picture_width * frame->picture_height, cell = 0;
    for (size_t i = 0; i < pixels; i++) {
        disparities[i] = QS_NO_DISPARITY;
    }
    for (size_t y = 0; y < labels->height; y++) {
        int32_t *row = disparities + (frame->y + y) * frame->picture_width + frame->x;
        for (size_t x = 0; x < labels->width; x++, cell++) {
            if (is_site(labels->mask, cell)) {
                row[x] = frame->first + *labelling++;
            }
        }
    }
}

qs_status qs_map_of_labelling(const qs_labels *labels, const uint16_t *labelling,
                              int32_t *disparities)
{
    if (!labels || !labelling || !disparities) {
        return QS_E_ARGUMENT;
    }
    if (labels->width == 0 || !is_inside(labels)) {
        return QS_E_GEOMETRY;
    }
    if ((int64_t)labels->frame.first + labels->labels - 1 > INT32_MAX) {
        return QS_E_OVERFLOW;
    }
    if (!labels_exist(labels, labelling)) {
        return QS_E_ARGUMENT;
    }
    place(labels, labelling, disparities);
    return QS_OK;
}
