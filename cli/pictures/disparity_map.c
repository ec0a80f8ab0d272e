#include "pictures/disparity_map.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "pictures/picture_read.h"
#include "pictures/picture_write.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

/* In units of 1/PFM_SCALE pixel. Returns false if the value is too large for a disparity. */
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
                        "pixel (%zu, %zu) holds %g, which is not a disparity in pixels",
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
                      "is a picture in colours: give a grey one, with one value per pixel");
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
    budget owner;
    file_bytes file;
    *values = NULL;
    int status = picture_read_file(path, &owner, &file);
    if (status == DONE) {
        status = pfm_is(&file) ? read_pfm(path, &file, map, values)
                               : read_integers(path, &file, scale, map, values);
    }
    budget_free(&owner);
    if (status != DONE) {
        free(*values);
        *values = NULL;
    }
    return status;
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
    int32_t largest = 0; /* QS_NO_DISPARITY is less */
    for (size_t i = 0; i < count; i++) {
        largest = map->disparities[i] > largest ? map->disparities[i] : largest;
    }
    uint64_t most = qs_disparity_hold((uint32_t)largest, scale);
    if (most > 65535) {
        return fail_too_large(path, (uint32_t)largest, scale);
    }
    made->maxval = most > 255 ? 65535 : 255;
    for (size_t i = 0; i < count; i++) {
        int32_t disparity = map->disparities[i];
        made->samples[i] = disparity == QS_NO_DISPARITY
                               ? 0
                               : (uint16_t)qs_disparity_hold((uint32_t)disparity, scale);
    }
    return DONE;
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
            map->disparities[i] == QS_NO_DISPARITY ? INFINITY : (float)map->disparities[i];
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
        status = picture_encode(&made, format == MAP_PNG, path, file);
    }
    picture_free(&made);
    return status;
}

/* The colour of `value` on a scale that ends at `most`: straight lines between nine points of a
 * map after Google's Turbo, in integers, so that every machine draws the same. */
static void colour_of(uint32_t value, uint32_t most, uint16_t rgb[3])
{
    enum { STEPS = 8, PART = 256 };
    static const uint8_t points[STEPS + 1][3] = {{48, 18, 59},   {70, 107, 227}, {40, 187, 236},
                                                 {49, 242, 153}, {162, 252, 60}, {237, 208, 58},
                                                 {251, 128, 34}, {210, 49, 5},   {122, 4, 3}};
    uint64_t place = most > 0 ? (uint64_t)value * STEPS * PART / most : 0;
    unsigned step = (unsigned)(place / PART), part = (unsigned)(place % PART);
    for (unsigned c = 0; c < 3; c++) {
        unsigned from = points[step][c], to = points[step + (part > 0)][c];
        rgb[c] = (uint16_t)((from * (PART - part) + to * part + PART / 2) / PART);
    }
}

int map_encode_colour(const pixel_map *map, bool png, const char *path, file_bytes *file)
{
    picture made = {map->width, map->height, 3, 255, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(path);
    }
    memset(made.samples, 0, made.width * made.height * 3 * sizeof *made.samples);
    for (size_t i = 0; i < made.width * made.height; i++) {
        int32_t disparity = map->disparities[i];
        if (disparity != QS_NO_DISPARITY) {
            colour_of((uint32_t)disparity - map->least, map->most - map->least,
                      made.samples + 3 * i);
        }
    }
    int status = picture_encode(&made, png, path, file);
    picture_free(&made);
    return status;
}

int map_check(const char *name, const qs_labels *labels)
{
    if (labels->width == 0) {
        return fail(BAD_INPUT, name,
                    "is not a problem on a grid of pixels, so no map can be made from it");
    }
    uint64_t last = (uint64_t)labels->frame.first + labels->labels - 1;
    if (last > INT32_MAX) {
        return fail(BAD_INPUT, name,
                    "its disparities end at %" PRIu64 ", which is more than a map can hold", last);
    }
    return DONE;
}

int map_of_labelling(const char *name, const qs_labels *labels, const uint16_t *labelling,
                     budget *limit, pixel_map *map)
{
    const qs_frame *frame = &labels->frame;
    if (frame->picture_height > SIZE_MAX / sizeof *map->disparities / frame->picture_width) {
        return budget_fail(limit, name);
    }
    size_t size = sizeof *map->disparities * frame->picture_width * frame->picture_height;
    *map = (pixel_map){budget_take(limit, name, size), frame->picture_width, frame->picture_height,
                       frame->first, frame->first + labels->labels - 1};
    if (map->disparities == NULL) {
        return NO_RESOURCE;
    }
    qs_status placed = qs_map_of_labelling(labels, labelling, map->disparities);
    return placed == QS_OK ? DONE : fail_status(name, placed);
}

/* The format that the name of an output asks for. What is written straight needs no ending: it is a
 * PGM. Returns DONE or BAD_USAGE. */
static int format_of(const char *path, map_format *format)
{
    if (path_ends(path, ".pfm")) {
        *format = MAP_PFM;
    } else if (path_ends(path, ".png")) {
        *format = MAP_PNG;
    } else if (output_is_straight(path) || path_ends(path, ".pgm")) {
        *format = MAP_PGM;
    } else {
        return fail_usage("-o %s: the name of a map ends in .png, .pgm or .pfm", path);
    }
    if (*format == MAP_PNG && !picture_library_writes_png()) {
        return fail_usage("-o %s: this build writes only .pgm and .pfm; for .png build "
                          "qstereo with OpenCV (make OPENCV=1)",
                          path);
    }
    return DONE;
}

/* A map in colours is a PNG beside everything but a PGM, if PNG can be written. */
static bool colour_is_png(const map_request *asked)
{
    return asked->format != MAP_PGM && picture_library_writes_png();
}

static int name_colour(budget *limit, map_request *asked)
{
    if (output_is_straight(asked->output)) {
        return fail_usage("--color needs the name of a file to put its map beside: name one "
                          "with -o");
    }
    const char *slash = strrchr(asked->output, '/');
    const char *dot = strrchr(slash != NULL ? slash : asked->output, '.');
    int stem = (int)(dot - asked->output);
    size_t size = strlen(asked->output) + sizeof ".color.png";
    asked->colour = budget_take(limit, asked->output, size);
    if (asked->colour == NULL) {
        return NO_RESOURCE;
    }
    (void)snprintf(asked->colour, size, "%.*s.color.%s", stem, asked->output,
                   colour_is_png(asked) ? "png" : "ppm");
    return DONE;
}

int map_scale_read(const char *text, uint32_t *scale)
{
    return number_read("--scale", text, 2, 65535, scale);
}

int map_request_read(const char *path, const char *scale, bool color, budget *limit,
                     map_request *asked)
{
    memset(asked, 0, sizeof *asked);
    asked->output = path;
    TRY(format_of(path, &asked->format));
    TRY(map_scale_read(scale, &asked->scale));
    return color ? name_colour(limit, asked) : DONE;
}

int map_request_open(map_request *asked, job *at)
{
    TRY(job_open_output(at, asked->output, &asked->files[0]));
    return asked->colour != NULL ? job_open_output(at, asked->colour, &asked->files[1]) : DONE;
}

int map_request_write(const map_request *asked, const pixel_map *map)
{
    file_bytes files[2] = {{NULL, 0}, {NULL, 0}};
    int status = map_encode(map, asked->format, asked->scale, asked->output, &files[0]);
    if (status == DONE && asked->colour != NULL) {
        status = map_encode_colour(map, colour_is_png(asked), asked->colour, &files[1]);
    }
    for (size_t i = 0; i < 2; i++) {
        if (status == DONE && asked->files[i] != NULL) {
            output_write_file(asked->files[i], &files[i]);
        }
        file_free(&files[i]);
    }
    return status;
}

void map_request_json(const map_request *asked)
{
    json_name("map", asked->output);
    json_name("color_map", asked->colour);
}

void map_request_print(const map_request *asked)
{
    printf("%s%s%s: ", asked->output, asked->colour != NULL ? ", " : "",
           asked->colour != NULL ? asked->colour : "");
}
