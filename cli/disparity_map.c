#include "disparity_map.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "colour.h"
#include "messages.h"

/* In units of 1/PFM_SCALE pixel; false = too large to be a disparity. */
static bool hold_float(float value, int32_t *held)
{
    *held = QS_NO_DISPARITY;
    if (!isfinite(value)) {
        return true;
    }
    if (value <= -32767.0F || value >= 32767.0F) {
        return false;
    }
    *held = (int32_t)floor((double)value * PFM_SCALE + 0.5);
    return true;
}

static int hold_floats(const char *path, const float_picture *floats, int32_t *values)
{
    for (size_t i = 0; i < floats->width * floats->height; i++) {
        if (!hold_float(floats->values[i], &values[i])) {
            return fail(BAD_INPUT, input_name(path),
                        "pixel (%zu, %zu) holds %g, which is no disparity in pixels",
                        i % floats->width, i / floats->width, (double)floats->values[i]);
        }
    }
    return DONE;
}

static int read_pfm(const char *path, const file_bytes *file, qs_map *map, int32_t **values)
{
    float_picture floats;
    char reason[REASON_SIZE] = "";
    int status = picture_fail(path, pfm_decode(file, &floats, reason), reason);
    if (status != DONE) {
        return status;
    }
    *values = malloc(floats.width * floats.height * sizeof **values);
    status = *values != NULL ? hold_floats(path, &floats, *values) : fail_memory(input_name(path));
    *map = (qs_map){*values, floats.width, floats.height, PFM_SCALE};
    free(floats.values);
    return status;
}

static int read_integers(const char *path, const file_bytes *file, uint32_t scale, qs_map *map,
                         int32_t **values)
{
    picture integers;
    int status = picture_decode(path, file, &integers);
    if (status != DONE) {
        return status;
    }
    size_t count = integers.width * integers.height;
    if (integers.channels != 1) {
        status = fail(BAD_INPUT, input_name(path),
                      "is a picture in colours: a disparity map is grey, one value a pixel");
    } else if ((*values = malloc(count * sizeof **values)) == NULL) {
        status = fail_memory(input_name(path));
    }
    for (size_t i = 0; i < count && status == DONE; i++) {
        (*values)[i] = qs_disparity_read(integers.samples[i], scale);
    }
    *map = (qs_map){*values, integers.width, integers.height, scale};
    picture_free(&integers);
    return status;
}

int map_read(const char *path, uint32_t scale, qs_map *map, int32_t **values)
{
    file_bytes file;
    int status = picture_read_file(path, &file);
    *values = NULL;
    if (status != DONE) {
        return status;
    }
    status = pfm_is(&file) ? read_pfm(path, &file, map, values)
                           : read_integers(path, &file, scale, map, values);
    file_free(&file);
    if (status != DONE) {
        free(*values);
        *values = NULL;
    }
    return status;
}

static bool same_letters(const char *a, const char *b)
{
    for (; *a != '\0' && *b != '\0'; a++, b++) {
        if ((*a | 0x20) != (*b | 0x20)) {
            return false;
        }
    }
    return *a == *b;
}

int map_format_of(const char *path, bool straight, map_format *format)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash != NULL ? slash : path, '.');
    if (dot != NULL && same_letters(dot, ".pfm")) {
        *format = MAP_PFM;
    } else if (dot != NULL && same_letters(dot, ".png")) {
        *format = MAP_PNG;
    } else if (straight || (dot != NULL && same_letters(dot, ".pgm"))) {
        *format = MAP_PGM;
    } else {
        return fail_usage("-o %s: a map's name ends in .png, .pgm or .pfm", path);
    }
    if (*format == MAP_PNG && !picture_library_writes_png()) {
        return fail_usage("-o %s: this build writes .pgm and .pfm; for .png build qstereo with "
                          "OpenCV (make OPENCV=1)",
                          path);
    }
    return DONE;
}

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

static int hold_integers(const pixel_map *map, uint32_t scale, const char *path, picture *made)
{
    size_t count = made->width * made->height;
    uint32_t largest = 0;
    for (size_t i = 0; i < count; i++) {
        if (map->disparities[i] != MAP_NO_VALUE && map->disparities[i] > largest) {
            largest = map->disparities[i];
        }
    }
    uint64_t most = qs_disparity_hold(largest, scale);
    if (most > 65535) {
        return fail_too_large(path, largest, scale);
    }
    made->maxval = most > 255 ? 65535 : 255;
    for (size_t i = 0; i < count; i++) {
        made->samples[i] = map->disparities[i] == MAP_NO_VALUE
                               ? 0
                               : (uint16_t)qs_disparity_hold(map->disparities[i], scale);
    }
    return DONE;
}

static int encode_picture(const picture *made, bool png, const char *path, file_bytes *file)
{
    picture_status status = png ? picture_library_encode_png(made, file) : pnm_encode(made, file);
    return picture_fail(path, status, "cannot be made");
}

static int encode_pfm(const pixel_map *map, const char *path, file_bytes *file)
{
    size_t count = (size_t)map->width * map->height;
    float_picture made = {map->width, map->height, malloc(count * sizeof *made.values)};
    if (made.values == NULL) {
        return fail_memory(path);
    }
    for (size_t i = 0; i < count; i++) {
        made.values[i] =
            map->disparities[i] == MAP_NO_VALUE ? INFINITY : (float)map->disparities[i];
    }
    int status = picture_fail(path, pfm_encode(&made, file), "cannot be made");
    free(made.values);
    return status;
}

int map_encode(const pixel_map *map, map_format format, uint32_t scale, const char *path,
               file_bytes *file)
{
    picture made = {map->width, map->height, 1, 255, NULL};
    if (format == MAP_PFM) {
        return encode_pfm(map, path, file);
    }
    if (!picture_allocate(&made)) {
        return fail_memory(path);
    }
    int status = hold_integers(map, scale, path, &made);
    if (status == DONE) {
        status = encode_picture(&made, format == MAP_PNG, path, file);
    }
    picture_free(&made);
    return status;
}

int map_encode_colour(const pixel_map *map, bool png, const char *path, file_bytes *file)
{
    picture made = {map->width, map->height, 3, 255, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(path);
    }
    memset(made.samples, 0, made.width * made.height * 3 * sizeof *made.samples);
    for (size_t i = 0; i < made.width * made.height; i++) {
        if (map->disparities[i] != MAP_NO_VALUE) {
            colour_of(map->disparities[i] - map->least, map->most - map->least,
                      made.samples + 3 * i);
        }
    }
    int status = encode_picture(&made, png, path, file);
    picture_free(&made);
    return status;
}
