#include "../../include/qstereo/maps.h"

static uint16_t mean_at(const uint16_t *values, size_t width, size_t height, size_t x, size_t y)
{
    uint32_t sum = 0, count = 0;
    size_t right = x + 1 < width ? x + 1 : x, below = y + 1 < height ? y + 1 : y;
    for (size_t j = y > 0 ? y - 1 : 0; j <= below; j++) {
        for (size_t i = x > 0 ? x - 1 : 0; i <= right; i++) {
            sum += values[j * width + i];
            count++;
        }
    }
    return (uint16_t)((sum + count - 1) / count);
}

qs_status qs_map_mean(const uint16_t *values, size_t width, size_t height, uint16_t *out)
{
    if (!values || !out || values == out) {
        return QS_E_ARGUMENT;
    }
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            size_t at = y * width + x;
            out[at] = values[at] == 0 ? 0 : mean_at(values, width, height, x, y);
        }
    }
    return QS_OK;
}
