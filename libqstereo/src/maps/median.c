#include "../../include/qstereo/maps.h"

enum { MOST = 9 };

/* Puts a value at its place among the sorted ones before it. */
static void insert(int32_t *sorted, int count, int32_t value)
{
    int at = count;
    for (; at > 0 && sorted[at - 1] > value; at--) {
        sorted[at] = sorted[at - 1];
    }
    sorted[at] = value;
}

static int32_t median_at(const int32_t *values, size_t width, size_t height, size_t x, size_t y)
{
    int32_t sorted[MOST] = {QS_NO_DISPARITY}; /* what is left where no neighbour has a value */
    int count = 0;
    size_t right = x + 1 < width ? x + 1 : x, below = y + 1 < height ? y + 1 : y;
    for (size_t j = y > 0 ? y - 1 : 0; j <= below; j++) {
        for (size_t i = x > 0 ? x - 1 : 0; i <= right; i++) {
            int32_t value = values[j * width + i];
            if (value != QS_NO_DISPARITY) {
                insert(sorted, count, value);
                count++;
            }
        }
    }
    return sorted[(count - 1) / 2];
}

qs_status qs_map_median(const int32_t *values, size_t width, size_t height, int32_t *out)
{
    if (!values || !out || values == out) {
        return QS_E_ARGUMENT;
    }
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            size_t at = y * width + x;
            out[at] = values[at] == QS_NO_DISPARITY ? QS_NO_DISPARITY
                                                    : median_at(values, width, height, x, y);
        }
    }
    return QS_OK;
}
