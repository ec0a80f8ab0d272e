#include "../../include/qstereo/maps.h"

enum { UNIT_MAX = 65536 };

/* The largest whole number that is at most a / b. */
static int64_t floor_of(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

/* The column that the match of column x is nearest to; of two, the right one. */
static int64_t match_of(size_t x, int32_t value, uint32_t unit)
{
    int64_t twice = 2 * (int64_t)value + unit - 1;
    return (int64_t)x - floor_of(twice, 2 * (int64_t)unit);
}

static void check_row(int32_t *left, const int32_t *right, size_t width, uint32_t unit,
                      uint32_t tolerance)
{
    for (size_t x = 0; x < width; x++) {
        if (left[x] == QS_NO_DISPARITY) {
            continue;
        }
        int64_t match = match_of(x, left[x], unit);
        bool inside = match >= 0 && (uint64_t)match < width;
        int32_t other = inside ? right[match] : QS_NO_DISPARITY;
        int64_t off = (int64_t)left[x] - other;
        if (other == QS_NO_DISPARITY || off > tolerance || -off > tolerance) {
            left[x] = QS_NO_DISPARITY;
        }
    }
}

qs_status qs_map_check(int32_t *left, const int32_t *right, size_t width, size_t height,
                       uint32_t unit, uint32_t tolerance)
{
    if (!left || !right || unit < 1 || unit > UNIT_MAX) {
        return QS_E_ARGUMENT;
    }
    for (size_t y = 0; y < height; y++) {
        check_row(left + y * width, right + y * width, width, unit, tolerance);
    }
    return QS_OK;
}
