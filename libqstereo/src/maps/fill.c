#include "../../include/qstereo/maps.h"
#include "../base/minmax.h"

/* What a hole between two values is filled with; QS_NO_DISPARITY = there is no value. */
static int32_t filling(int32_t before, int32_t after)
{
    if (before == QS_NO_DISPARITY || after == QS_NO_DISPARITY) {
        return before == QS_NO_DISPARITY ? after : before;
    }
    return qs_min_i32(before, after);
}

static void fill_row(int32_t *values, size_t width)
{
    int32_t before = QS_NO_DISPARITY;
    for (size_t x = 0; x < width;) {
        size_t end = x;
        while (end < width && values[end] == QS_NO_DISPARITY) {
            end++;
        }
        int32_t value = filling(before, end < width ? values[end] : QS_NO_DISPARITY);
        for (; x < end; x++) {
            values[x] = value;
        }
        before = x < width ? values[x] : before;
        x++;
    }
}

qs_status qs_map_fill(int32_t *values, size_t width, size_t height)
{
    if (!values) {
        return QS_E_ARGUMENT;
    }
    for (size_t y = 0; y < height; y++) {
        fill_row(values + y * width, width);
    }
    return QS_OK;
}
