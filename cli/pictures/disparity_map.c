#include "pictures/disparity_map.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "pictures/picture_read.h"
#include "pictures/picture_size.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

int map_form_read(const char *scale_option, const char *scale, const char *no_value_option,
                  const char *no_value, map_form *form)
{
    *form = (map_form){.has_no_value = no_value != NULL};
    TRY(number_read(scale_option, scale, 1, 65536, &form->scale));
    return no_value != NULL ? real_read(no_value_option, no_value, &form->no_value) : DONE;
}

static bool is_no_value(const map_form *form, double value)
{
    return form->has_no_value &&
           (value == form->no_value || (form->no_value < 0 && value < form->no_value));
}

/* In units of 1/PFM_SCALE pixel. Returns false if the value is too large for a disparity. */
static bool hold_float(const map_form *form, float value, int32_t *held)
{
    *held = QS_NO_DISPARITY;
    if (!isfinite(value) || is_no_value(form, (double)value)) {
        return true;
    }
    if (value <= -32767.0F || value >= 32767.0F) {
        return false;
    }
    *held = (int32_t)floor((double)value * PFM_SCALE + 0.5);
    return true;
}

static int32_t hold_whole(const map_form *form, int32_t value)
{
    if (form->has_no_value) {
        return is_no_value(form, value) ? QS_NO_DISPARITY : value;
    }
    return value > 0 ? qs_disparity_read((uint32_t)value, form->scale) : QS_NO_DISPARITY;
}

static int hold_floats(const char *path, const map_form *form, const float_picture *floats,
                       int32_t *values)
{
    for (size_t i = 0; i < floats->width * floats->height; i++) {
        float value = floats->values[i];
        if (floats->whole) {
            values[i] = hold_whole(form, (int32_t)value);
        } else if (!hold_float(form, value, &values[i])) {
            return fail(BAD_INPUT, input_name(path),
                        "pixel (%zu, %zu) holds %g, which is not a disparity in pixels",
                        i % floats->width, i / floats->width, (double)value);
        }
    }
    return DONE;
}

static int32_t *take_values(const char *path, budget *limit, size_t width, size_t height)
{
    return budget_take(limit, input_name(path), width * height * sizeof(int32_t));
}

static int decode_floats(const char *path, const file_bytes *file, float_picture *floats)
{
    char reason[REASON_SIZE] = "";
    floats->whole = false;
    picture_status status = pfm_is(file) ? pfm_decode(file, floats, reason)
                                         : picture_library_decode_floats(file, floats, reason);
    return picture_fail(path, status, reason);
}

static int read_floats(const char *path, const file_bytes *file, const map_form *form,
                       budget *limit, qs_map *map)
{
    float_picture floats;
    picture stated = {.channels = 1};
    uint64_t size = file->size; /* of the floats of a PFM */
    if (!pfm_is(file) && picture_size(file, &stated)) {
        size = bytes_product(picture_bytes(&stated), 2);
    }
    TRY(budget_need(limit, input_name(path), bytes_product(size, 2)));
    TRY(decode_floats(path, file, &floats));
    int32_t *values = take_values(path, limit, floats.width, floats.height);
    int status = values != NULL ? hold_floats(path, form, &floats, values) : NO_RESOURCE;
    *map = (qs_map){values, floats.width, floats.height, floats.whole ? form->scale : PFM_SCALE};
    free(floats.values);
    return status;
}

/* Checks that a picture in colours has greys alone, as a palette of greys gives it. */
static int check_greys(const char *path, const picture *coloured)
{
    for (size_t i = 0; coloured->channels == 3 && i < coloured->width * coloured->height; i++) {
        const uint16_t *pixel = coloured->samples + 3 * i;
        if (pixel[0] != pixel[1] || pixel[0] != pixel[2]) {
            return fail(BAD_INPUT, input_name(path),
                        "is a picture in colours: give a grey one, with one value per pixel");
        }
    }
    return DONE;
}

static int hold_samples(const char *path, const picture *integers, const map_form *form,
                        budget *limit, qs_map *map)
{
    size_t count = integers->width * integers->height;
    TRY(check_greys(path, integers));
    int32_t *values = take_values(path, limit, integers->width, integers->height);
    if (values == NULL) {
        return NO_RESOURCE;
    }
    for (size_t i = 0; i < count; i++) {
        values[i] = hold_whole(form, integers->samples[i * integers->channels]);
    }
    *map = (qs_map){values, integers->width, integers->height, form->scale};
    return DONE;
}

static int read_integers(const char *path, const file_bytes *file, const map_form *form,
                         budget *limit, qs_map *map)
{
    picture integers;
    TRY(picture_decode(path, file, limit, &integers));
    int status = hold_samples(path, &integers, form, limit, map);
    picture_free(&integers);
    return status;
}

int map_read(const char *path, const map_form *form, budget *limit, qs_map *map)
{
    budget work = budget_inside(limit);
    file_bytes file;
    int status = file_read(path, &work, &file);
    if (status == DONE) {
        limit->left -= file.size; /* while the file is there */
        bool floats = pfm_is(&file) || picture_is_signed(&file);
        status = (floats ? read_floats : read_integers)(path, &file, form, limit, map);
        limit->left += file.size;
    }
    budget_free(&work);
    return status;
}

/* White is the largest sample that there can be: in the masks of Middlebury, pixels that are
 * visible in both pictures. */
static int mask_out(const char *path, const picture *mask, qs_map *map)
{
    int32_t *values = (int32_t *)map->values;
    if (mask->width != map->width || mask->height != map->height) {
        return fail(BAD_INPUT, input_name(path), "is %zu x %zu pixels, but the truth is %zu x %zu",
                    mask->width, mask->height, map->width, map->height);
    }
    for (size_t i = 0; i < mask->width * mask->height; i++) {
        if (mask->samples[i * mask->channels] != mask->maxval) {
            values[i] = QS_NO_DISPARITY;
        }
    }
    return DONE;
}

int map_apply_mask(const char *path, budget *limit, qs_map *map)
{
    budget work = budget_inside(limit);
    file_bytes file;
    picture mask = {.samples = NULL};
    int status = file_read(path, &work, &file);
    status = status == DONE ? picture_decode(path, &file, &work, &mask) : status;
    status = status == DONE ? check_greys(path, &mask) : status;
    status = status == DONE ? mask_out(path, &mask, map) : status;
    picture_free(&mask);
    budget_free(&work);
    return status;
}

int map_check(const char *name, const qs_labels *labels, map_format format)
{
    if (labels->width == 0) {
        return fail(BAD_INPUT, name,
                    "is not a problem on a grid of pixels, so no map can be made from it");
    }
    int64_t last = (int64_t)labels->frame.first + labels->labels - 1;
    if (last > INT32_MAX) {
        return fail(BAD_INPUT, name,
                    "its disparities end at %" PRId64 ", which is more than a map can hold", last);
    }
    if (format != MAP_PFM && labels->frame.first < 0) {
        return fail(BAD_INPUT, name,
                    "its disparities begin at %" PRId32 ", but a .png or .pgm holds none below 0: "
                    "name a .pfm with -o",
                    labels->frame.first);
    }
    return DONE;
}

/* A map in colours is a PNG beside everything but a PGM, if PNG can be written. */
static bool colour_is_png(const map_request *asked)
{
    return asked->format != MAP_PGM && picture_library_writes_png();
}

uint64_t map_bytes(const map_request *asked, const qs_labels *labels)
{
    /* Of each sample of a PNG: ours, those of the library in 16 and in 8 bits, the file, and its
     * copy. The other formats are written row by row. */
    enum { PNG_BYTES = 2 + 2 + 2 + 2 + 2 };
    uint64_t pixels = (uint64_t)labels->frame.picture_width * labels->frame.picture_height;
    uint64_t samples = asked->format == MAP_PNG ? pixels : 0;
    if (asked->colour != NULL && colour_is_png(asked)) {
        uint64_t bar = asked->colours.has_bar ? BAR_WIDTH : 0;
        samples = 3 * (pixels + bar * labels->frame.picture_height); /* one map after the other */
    }
    return bytes_sum(bytes_product(pixels, sizeof(int32_t)), bytes_product(samples, PNG_BYTES));
}

int map_of_labelling(const char *name, const qs_labels *labels, const uint16_t *labelling,
                     budget *limit, pixel_map *map)
{
    const qs_frame *frame = &labels->frame;
    uint64_t size = bytes_product((uint64_t)frame->picture_width * frame->picture_height,
                                  sizeof *map->disparities);
    TRY(budget_need(limit, name, size));
    uint32_t unit = labels->meaning.unit > 0 ? labels->meaning.unit : 1;
    *map = (pixel_map){budget_take(limit, name, (size_t)size),
                       unit,
                       frame->picture_width,
                       frame->picture_height,
                       frame->first,
                       frame->first + (int32_t)labels->labels - 1};
    if (map->disparities == NULL) {
        return NO_RESOURCE;
    }
    qs_status placed = qs_map_of_labelling(labels, labelling, map->disparities);
    return placed == QS_OK ? DONE : fail_status(name, placed);
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

/* The format that the name of an output asks for. What is written straight needs no ending: it is a
 * PGM. Returns DONE or BAD_USAGE. */
static int format_of(const char *path, map_format *format)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash != NULL ? slash : path, '.');
    if (dot != NULL && same_letters(dot, ".pfm")) {
        *format = MAP_PFM;
    } else if (dot != NULL && same_letters(dot, ".png")) {
        *format = MAP_PNG;
    } else if (output_is_straight(path) || (dot != NULL && same_letters(dot, ".pgm"))) {
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

static int read_colours(const map_options *given, budget *limit, map_request *asked)
{
    int chosen;
    TRY(name_read(&palette_names, given->palette, "", &chosen));
    asked->colours = (colouring){(palette)chosen, given->scale_bar != NULL};
    return given->color != NULL ? name_colour(limit, asked) : DONE;
}

int map_request_read(const map_options *given, budget *limit, map_request *asked)
{
    bool is_pfm_on_standard = strcmp(given->output, "pfm:-") == 0;
    memset(asked, 0, sizeof *asked);
    asked->output = is_pfm_on_standard ? "-" : given->output;
    TRY(format_of(asked->output, &asked->format));
    asked->format = is_pfm_on_standard ? MAP_PFM : asked->format;
    TRY(map_scale_read(given->scale, &asked->scale));
    return read_colours(given, limit, asked);
}

int map_request_open(map_request *asked, job *at)
{
    if (at->json && output_is_standard(asked->output)) {
        return fail_usage("--json and --output cannot both go to standard output: "
                          "name a file with -o");
    }
    TRY(job_open_output(at, asked->output, &asked->files[0]));
    return asked->colour != NULL ? job_open_beside(at, "color", asked->colour, &asked->files[1])
                                 : DONE;
}

int map_request_write(const map_request *asked, const pixel_map *map)
{
    TRY(map_write(map, asked->format, asked->scale, asked->output, asked->files[0]));
    return asked->colour != NULL ? map_write_colour(map, &asked->colours, colour_is_png(asked),
                                                    asked->colour, asked->files[1])
                                 : DONE;
}

void map_request_json(const map_request *asked)
{
    json_name("map", asked->output);
    json_name("color_map", asked->colour);
}
