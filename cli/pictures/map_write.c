#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pictures/disparity_map.h"
#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "pictures/picture_read.h"
#include "text/fail.h"

static int fail_too_large(const char *path, uint32_t disparity, uint32_t scale)
{
    if (disparity > 65535 / 2) {
        return fail(BAD_INPUT, path,
                    "disparity %" PRIu32 " does not fit 16 bits at any --scale: write a .pfm",
                    disparity);
    }
    return fail(BAD_INPUT, path,
                "disparity %" PRIu32 " does not fit 16 bits at --scale %" PRIu32 ": %" PRIu32
                " is the largest scale that does",
                disparity, scale, 65535 / disparity);
}

/* How a map becomes a picture. */
typedef struct drawing {
    const pixel_map *map;
    const colouring *colours; /* NULL = grey */
    uint32_t scale; /* of grey */
} drawing;

static int32_t largest_of(const pixel_map *map)
{
    int32_t largest = 0; /* QS_NO_DISPARITY is less */
    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
        largest = map->disparities[i] > largest ? map->disparities[i] : largest;
    }
    return largest;
}

/* What a picture holds for a disparity in parts of a pixel, rounded. */
static uint64_t held(const drawing *from, uint32_t disparity)
{
    uint32_t unit = from->map->unit;
    uint64_t scaled = ((uint64_t)disparity * from->scale + unit / 2) / unit;
    return scaled > 0 ? scaled : qs_disparity_hold(0, from->scale);
}

/* The size and depth of the picture, whose samples are not made yet. */
static int plan(const drawing *from, const char *path, picture *made)
{
    *made =
        (picture){from->map->width, from->map->height, from->colours != NULL ? 3 : 1, 255, NULL};
    made->width += from->colours != NULL && from->colours->has_bar ? BAR_WIDTH : 0;
    if (from->colours == NULL) {
        uint32_t largest = (uint32_t)largest_of(from->map);
        uint64_t most = held(from, largest);
        if (most > 65535) {
            return fail_too_large(path, largest / from->map->unit, from->scale);
        }
        made->maxval = most > 255 ? 65535 : 255;
    }
    return DONE;
}

static void draw_coloured_row(const drawing *from, size_t y, uint16_t *samples)
{
    const pixel_map *map = from->map;
    const colouring *by = from->colours;
    for (size_t x = 0; x < map->width; x++, samples += 3) {
        int32_t disparity = map->disparities[y * map->width + x];
        memset(samples, 0, 3 * sizeof *samples);
        if (disparity != QS_NO_DISPARITY) {
            colour_of_value(by->palette, (uint32_t)disparity - (uint32_t)map->least,
                            (uint32_t)map->most - (uint32_t)map->least, samples);
        }
    }
    if (by->has_bar) {
        const colour_bar bar = {by->palette, map->least, map->most, map->unit, map->height};
        colour_bar_row(&bar, (uint32_t)y, samples);
    }
}

static void draw_row(const drawing *from, size_t y, uint16_t *samples)
{
    const pixel_map *map = from->map;
    if (from->colours != NULL) {
        draw_coloured_row(from, y, samples);
        return;
    }
    for (size_t x = 0; x < map->width; x++) {
        int32_t disparity = map->disparities[y * map->width + x];
        samples[x] = disparity == QS_NO_DISPARITY ? 0 : (uint16_t)held(from, (uint32_t)disparity);
    }
}

static int write_pnm(const drawing *from, const picture *made, const char *path, output *out)
{
    uint8_t header[HEADER_SIZE];
    size_t count = made->width * made->channels;
    uint16_t *samples = malloc(count * sizeof *samples);
    uint8_t *bytes = malloc(count * 2);
    bool ready = samples != NULL && bytes != NULL;
    if (ready) {
        (void)output_write(out, header, pnm_header(made, header));
    }
    for (size_t y = 0; y < made->height && ready; y++) {
        draw_row(from, y, samples);
        (void)output_write(out, bytes, pnm_pack(samples, count, made->maxval, bytes));
    }
    free(samples);
    free(bytes);
    return ready ? DONE : fail_memory(path);
}

static int write_png(const drawing *from, picture *made, const char *path, output *out)
{
    file_bytes file = {NULL, 0};
    if (!picture_allocate(made)) {
        return fail_memory(path);
    }
    for (size_t y = 0; y < made->height; y++) {
        draw_row(from, y, made->samples + y * made->width * made->channels);
    }
    picture_status encoded = picture_library_encode_png(made, &file);
    picture_free(made);
    int status = picture_fail(path, encoded, "cannot be made");
    if (status == DONE) {
        output_write_file(out, &file);
    }
    file_free(&file);
    return status;
}

static int write_pfm(const pixel_map *map, const char *path, output *out)
{
    uint8_t header[HEADER_SIZE];
    float *values = malloc(map->width * sizeof *values);
    uint8_t *bytes = malloc((size_t)map->width * 4);
    bool ready = values != NULL && bytes != NULL;
    if (ready) {
        (void)output_write(out, header, pfm_header(map->width, map->height, header));
    }
    for (size_t y = map->height; y-- > 0 && ready;) {
        for (size_t x = 0; x < map->width; x++) {
            int32_t disparity = map->disparities[y * map->width + x];
            values[x] =
                disparity == QS_NO_DISPARITY ? INFINITY : (float)disparity / (float)map->unit;
        }
        (void)output_write(out, bytes, pfm_pack(values, map->width, bytes));
    }
    free(values);
    free(bytes);
    return ready ? DONE : fail_memory(path);
}

static int write_drawing(const drawing *from, bool png, const char *path, output *out)
{
    picture made;
    TRY(plan(from, path, &made));
    return png ? write_png(from, &made, path, out) : write_pnm(from, &made, path, out);
}

int map_write(const pixel_map *map, map_format format, uint32_t scale, const char *path,
              output *out)
{
    const drawing grey = {map, NULL, scale};
    return format == MAP_PFM ? write_pfm(map, path, out)
                             : write_drawing(&grey, format == MAP_PNG, path, out);
}

int map_write_colour(const pixel_map *map, const colouring *by, bool png, const char *path,
                     output *out)
{
    const drawing coloured = {map, by, 0};
    return write_drawing(&coloured, png, path, out);
}
