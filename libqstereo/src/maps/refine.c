#include "../../include/qstereo/maps.h"

/* Where the parabola through three costs is least, in parts of a label from the middle one; `parts`
 * is even. The middle cost is the least of the three. */
static int32_t least_of(int64_t before, int64_t own, int64_t after, int32_t parts)
{
    int64_t bend = before - 2 * own + after; /* at least 0; 0 if all are equal */
    if (bend == 0) {
        return 0;
    }
    int64_t twice = (before - after) * parts; /* of twice the bend, |.| <= bend * parts */
    return (int32_t)((twice + (twice < 0 ? -bend : bend)) / (2 * bend));
}

/* Sixteenths of a pixel from the label to the least cost near it. */
static int32_t offset_of(const qs_model *model, size_t cell, uint32_t label, int32_t parts)
{
    const int32_t *costs = model->unary + cell * model->labels;
    if (label == 0 || label + 1 >= model->labels || costs[label] > costs[label - 1] ||
        costs[label] > costs[label + 1]) {
        return 0;
    }
    return least_of(costs[label - 1], costs[label], costs[label + 1], parts);
}

/* Sixteenths of a pixel from one label to the next; 0 = not a whole number of them. */
static uint32_t parts_of(const qs_labels *labels)
{
    uint32_t unit = labels->meaning.unit > 0 ? labels->meaning.unit : 1;
    bool whole = labels->meaning.kind == QS_MEANS_DISPARITY && QS_REFINED_UNIT % unit == 0;
    return whole ? QS_REFINED_UNIT / unit : 0;
}

qs_status qs_map_refine(const qs_model *model, const qs_labels *labels, const uint16_t *labelling,
                        int32_t *values)
{
    if (!model || !labels || !labelling || !values || parts_of(labels) == 0 ||
        model->width != labels->width || model->height != labels->height) {
        return QS_E_ARGUMENT;
    }
    int32_t parts = (int32_t)parts_of(labels);
    int64_t first = labels->frame.first, last = first + labels->labels;
    if (last * parts > INT32_MAX || first * parts <= -(int64_t)INT32_MAX) {
        return QS_E_OVERFLOW;
    }
    qs_status status = qs_map_of_labelling(labels, labelling, values);
    if (status != QS_OK) {
        return status;
    }
    const qs_frame *frame = &labels->frame;
    for (size_t y = 0; y < labels->height; y++) {
        int32_t *row = values + (frame->y + y) * frame->picture_width + frame->x;
        for (size_t x = 0; x < labels->width; x++) {
            if (row[x] != QS_NO_DISPARITY) {
                uint32_t label = (uint32_t)row[x] - (uint32_t)frame->first;
                int32_t offset = offset_of(model, y * labels->width + x, label, parts);
                row[x] = row[x] * parts + offset;
            }
        }
    }
    return QS_OK;
}
