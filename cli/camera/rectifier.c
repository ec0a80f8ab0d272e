#include "camera/rectifier.h"

#include <math.h>

#include "camera/lens.h"
#include "text/fail.h"

/* A coordinate in steps, kept in range: nothing is seen there, nor at infinity. */
static int32_t to_steps(double coordinate)
{
    const double most = 1 << 29;
    double steps = coordinate * PLACE_STEPS;
    if (!(steps > -most)) {
        return -(1 << 29);
    }
    return steps < most ? (int32_t)lrint(steps) : 1 << 29;
}

/* The rays of the rectified pixels go back through the projection and the rotation, and then
 * through the lens. */
static void fill_places(const camera *of, uint32_t width, uint32_t height, place *places)
{
    const double *p = of->projection;
    double back[9];
    matrix_transpose(of->rotation, back);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            double ray_y = (y - p[6]) / p[5];
            const point ray = {(x - p[2] - p[1] * ray_y) / p[0], ray_y};
            point pixel = lens_pixel(of, ray_turned(back, ray));
            *places++ = (place){to_steps(pixel.x), to_steps(pixel.y)};
        }
    }
}

static uint64_t table_bytes(uint64_t width, uint64_t height)
{
    return bytes_product(width * height, sizeof(place));
}

uint64_t rectifier_bytes(uint64_t width, uint64_t height)
{
    return bytes_product(table_bytes(width, height), 2);
}

int rectifier_make(const calibration *from, budget *limit, rectifier *made)
{
    uint64_t size = table_bytes(from->width, from->height);
    *made = (rectifier){{NULL, NULL}, from->width, from->height};
    for (int side = 0; side < 2; side++) {
        made->places[side] = budget_take(limit, from->name, size);
        if (made->places[side] == NULL) {
            return NO_RESOURCE;
        }
        fill_places(&from->cameras[side], from->width, from->height, made->places[side]);
    }
    return DONE;
}

static uint32_t sample_at(const picture *from, int32_t x, int32_t y, unsigned channel)
{
    if (x < 0 || y < 0 || (size_t)x >= from->width || (size_t)y >= from->height) {
        return 0;
    }
    return from->samples[((size_t)y * from->width + (size_t)x) * from->channels + channel];
}

/* The whole steps below a coordinate, also of a negative one, and what is left of it. */
static int32_t split(int32_t coordinate, uint32_t *rest)
{
    *rest = (uint32_t)coordinate % PLACE_STEPS;
    return (coordinate - (int32_t)*rest) / PLACE_STEPS;
}

static uint16_t sample_between(const picture *from, place at, unsigned channel)
{
    uint32_t right, below;
    int32_t x = split(at.x, &right), y = split(at.y, &below);
    uint32_t left = PLACE_STEPS - right, above = PLACE_STEPS - below;
    uint32_t sum = above * (left * sample_at(from, x, y, channel) +
                            right * sample_at(from, x + 1, y, channel)) +
                   below * (left * sample_at(from, x, y + 1, channel) +
                            right * sample_at(from, x + 1, y + 1, channel));
    return (uint16_t)((sum + PLACE_STEPS * PLACE_STEPS / 2) / (PLACE_STEPS * PLACE_STEPS));
}

int rectifier_apply(const rectifier *by, unsigned side, const picture *from, const char *name,
                    picture *to)
{
    *to = (picture){by->width, by->height, from->channels, from->maxval, NULL};
    if (!picture_allocate(to)) {
        return fail_memory(name);
    }
    uint16_t *sample = to->samples;
    const place *places = by->places[side];
    for (size_t i = 0; i < (size_t)by->width * by->height; i++) {
        for (unsigned channel = 0; channel < from->channels; channel++) {
            *sample++ = sample_between(from, places[i], channel);
        }
    }
    return DONE;
}
