#include "fields/warp.h"

#include <math.h>

static size_t within(double place, size_t count)
{
    return place <= 0 ? 0 : place >= (double)(count - 1) ? count - 1 : (size_t)place;
}

static double sample(const qs_image *from, double x, double y)
{
    double left = floor(x), top = floor(y), right = x - left, down = y - top;
    const uint8_t *upper = from->pixels + within(top, from->height) * from->stride,
                  *lower = from->pixels + within(top + 1, from->height) * from->stride;
    size_t a = within(left, from->width), b = within(left + 1, from->width);
    return (upper[a] * (1 - right) + upper[b] * right) * (1 - down) +
           (lower[a] * (1 - right) + lower[b] * right) * down;
}

void warp(const qs_image *moving, const flow_field *field, uint8_t *warped)
{
    for (uint32_t y = 0; y < field->height; y++) {
        for (uint32_t x = 0; x < field->width; x++) {
            size_t at = (size_t)y * field->width + x;
            const float *d = field->vectors + 2 * at;
            warped[at] = (uint8_t)lround(sample(moving, x + (double)d[0], y + (double)d[1]));
        }
    }
}
