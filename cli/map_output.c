#include "map_output.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"
#include "messages.h"
#include "numbers.h"

/* A map in colours is a PNG beside all that is no PGM, where PNG can be written. */
static bool colour_is_png(const map_request *asked)
{
    return asked->format != MAP_PGM && picture_library_writes_png();
}

static int name_colour(map_request *asked)
{
    if (output_is_straight(asked->output)) {
        return fail_usage("--color needs the name of a file to put its map beside");
    }
    const char *slash = strrchr(asked->output, '/');
    const char *dot = strrchr(slash != NULL ? slash : asked->output, '.');
    int stem = (int)(dot - asked->output);
    size_t size = strlen(asked->output) + sizeof ".color.png";
    asked->colour = malloc(size);
    if (asked->colour == NULL) {
        return fail_memory(asked->output);
    }
    (void)snprintf(asked->colour, size, "%.*s.color.%s", stem, asked->output,
                   colour_is_png(asked) ? "png" : "ppm");
    return DONE;
}

int map_scale_read(const char *text, uint32_t *scale)
{
    return number_read("--scale", text, 2, 65535, scale);
}

int map_request_read(const char *path, const char *scale, bool color, bool json, map_request *asked)
{
    memset(asked, 0, sizeof *asked);
    asked->output = path;
    int status = map_format_of(path, output_is_straight(path), &asked->format);
    if (status == DONE) {
        status = map_scale_read(scale, &asked->scale);
    }
    if (status == DONE && json && output_is_standard(path)) {
        status = fail_usage("--json and the map cannot both go to standard output");
    }
    return status == DONE && color ? name_colour(asked) : status;
}

void map_request_free(map_request *asked)
{
    free(asked->colour);
    asked->colour = NULL;
}

int map_check_grid(const problem_file *problem)
{
    const qs_labels *labels = &problem->qubo.labels;
    if (!problem->qubo.has_labels || labels->width == 0) {
        return fail(BAD_INPUT, problem->name,
                    "is no problem on a grid of pixels, so there is no map to be made of it");
    }
    uint64_t last = (uint64_t)labels->frame.first + labels->labels - 1;
    if (last > INT32_MAX) {
        return fail(BAD_INPUT, problem->name,
                    "its disparities end at %" PRIu64 ", more than can be held", last);
    }
    return DONE;
}

/* Puts the label of each site where the site is in the picture. */
static void place_sites(const qs_labels *labels, const uint16_t *labelling, uint32_t *disparities)
{
    const qs_frame *frame = &labels->frame;
    size_t site = 0;
    for (size_t cell = 0; cell < (size_t)labels->width * labels->height; cell++) {
        size_t x = frame->x + cell % labels->width, y = frame->y + cell / labels->width;
        if (labels->mask == NULL || (labels->mask[cell / 8] >> cell % 8 & 1) != 0) {
            disparities[y * frame->picture_width + x] = frame->first + labelling[site++];
        }
    }
}

int map_of_labelling(const problem_file *problem, const uint16_t *labelling, budget *limit,
                     uint32_t **disparities, pixel_map *map)
{
    const qs_labels *labels = &problem->qubo.labels;
    const qs_frame *frame = &labels->frame;
    void *pixels = NULL;
    if (frame->picture_height > SIZE_MAX / sizeof **disparities / frame->picture_width) {
        return budget_fail(limit, problem->name);
    }
    size_t count = (size_t)frame->picture_width * frame->picture_height;
    int status = budget_allocate(limit, problem->name, count * sizeof **disparities, &pixels);
    if (status != DONE) {
        return status;
    }
    *disparities = pixels;
    for (size_t i = 0; i < count; i++) {
        (*disparities)[i] = MAP_NO_VALUE;
    }
    place_sites(labels, labelling, *disparities);
    *map = (pixel_map){*disparities, frame->picture_width, frame->picture_height, frame->first,
                       frame->first + labels->labels - 1};
    return DONE;
}

int map_outputs_open(const map_request *asked, map_outputs *opened)
{
    opened->count = 0;
    int status = output_open(&opened->outs[0], asked->output);
    if (status != DONE) {
        return status;
    }
    opened->count = 1;
    if (asked->colour != NULL) {
        status = output_open(&opened->outs[1], asked->colour);
        opened->count += status == DONE;
    }
    if (status != DONE) {
        map_outputs_abandon(opened);
    }
    return status;
}

int map_outputs_write(const map_request *asked, const pixel_map *map, map_outputs *to)
{
    file_bytes files[2] = {{NULL, 0}, {NULL, 0}};
    int status = map_encode(map, asked->format, asked->scale, asked->output, &files[0]);
    if (status == DONE && asked->colour != NULL) {
        status = map_encode_colour(map, colour_is_png(asked), asked->colour, &files[1]);
    }
    for (size_t i = 0; i < to->count && status == DONE; i++) {
        (void)output_write(&to->outs[i], files[i].bytes,
                           files[i].size); /* a refusal is reported by the commit */
    }
    file_free(&files[0]);
    file_free(&files[1]);
    return status;
}

int map_outputs_commit(map_outputs *to)
{
    return output_commit(to->outs, to->count);
}

void map_outputs_abandon(map_outputs *to)
{
    while (to->count > 0) {
        output_abandon(&to->outs[--to->count]);
    }
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
