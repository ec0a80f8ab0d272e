/* Disparity maps: made from a labelling, as files, and in colours.
 *
 * As files they hold whole numbers (disparity * scale, 0 = no value) in .pgm and .png, or pixels as
 * floats in .pfm. Each function that can fail returns an exit status and has printed why. */
#ifndef DISPARITY_MAP_H
#define DISPARITY_MAP_H

#include "command.h"
#include "files.h"
#include "pictures/colour_map.h"
#include "qstereo.h"

/* The scale at which the floats of a PFM are held. */
#define PFM_SCALE 65536u

/* What the numbers in the file of a map mean. */
typedef struct map_form {
    uint32_t scale; /* whole numbers hold disparity * scale, floats pixels */
    /* A value that says no value; if it is negative, lower ones say so too. Without it these do: 0
     * and negative whole numbers, and floats that are not finite. With it 0 and 1 are disparities
     * like others, but floats that are not finite are none all the same. */
    bool has_no_value;
    double no_value;
} map_form;

#define NO_VALUE_HELP "the number that says no value; if it is negative, so do lower ones"

/* Reads the arguments of options for a form; `no_value` NULL = not given. Returns DONE or
 * BAD_USAGE. */
int map_form_read(const char *scale_option, const char *scale, const char *no_value_option,
                  const char *no_value, map_form *form);

/* Reads a map, whose values the budget owns. Returns DONE, BAD_INPUT or NO_RESOURCE. */
int map_read(const char *path, const map_form *form, budget *limit, qs_map *map);

/* Takes out of a map what is not white in the mask, a picture of the same size. Returns DONE,
 * BAD_INPUT or NO_RESOURCE. */
int map_apply_mask(const char *path, budget *limit, qs_map *map);

/* A map in parts of a pixel. */
typedef struct pixel_map {
    int32_t *disparities; /* row after row; QS_NO_DISPARITY = no value. The budget owns them */
    uint32_t unit; /* parts in a pixel */
    uint32_t width, height;
    int32_t least, most; /* the range of the colours */
} pixel_map;

typedef enum map_format { MAP_PGM, MAP_PNG, MAP_PFM } map_format;

/* Checks that a map of this format can be made from labels. `name` is for the message. Returns DONE
 * or BAD_INPUT. */
int map_check(const char *name, const qs_labels *labels, map_format format);

/* Makes the map of a labelling, after map_check. Returns DONE or NO_RESOURCE. */
int map_of_labelling(const char *name, const qs_labels *labels, const uint16_t *labelling,
                     budget *limit, pixel_map *map);

typedef struct colouring {
    palette palette;
    bool has_bar; /* a bar beside the map says which colour is which disparity */
} colouring;

/* Write the map, and the map in colours, as a PNG or a PPM: no value is black. Return DONE,
 * BAD_INPUT (a value does not fit) or NO_RESOURCE; job_commit reports refused bytes. */
int map_write(const pixel_map *map, map_format format, uint32_t scale, const char *path,
              output *out);
int map_write_colour(const pixel_map *map, const colouring *by, bool png, const char *path,
                     output *out);

/* The map that a command writes, and the map in colours beside it: rows for a table of options. */
#define MAP_OUTPUT_OPTION                                                                          \
    {"output", 'o',                                                                                \
     true,     "MAP",                                                                              \
     NULL,     "map to write: .png, .pgm or .pfm; - is standard output, as PGM, and pfm:- as PFM"}
#define SCALE_OPTION                                                                               \
    {"scale",                                                                                      \
     0,                                                                                            \
     false,                                                                                        \
     "S",                                                                                          \
     "8",                                                                                          \
     "a .png or .pgm holds disparity x S, from 2; a .pfm holds pixels",                            \
     .needs = "maps"}
#define COLOR_OPTION                                                                               \
    {"color", 0, false, NULL, NULL, "write a map in colours beside it, MAP.color.png (or .ppm)"}
#define PALETTE_OPTION                                                                             \
    {"palette",       0, false, "NAME", "turbo", "colours of that map: turbo or viridis",          \
     .needs = "color"}
#define SCALE_BAR_OPTION                                                                           \
    {"scale-bar",                                                                                  \
     0,                                                                                            \
     false,                                                                                        \
     NULL,                                                                                         \
     NULL,                                                                                         \
     "draw a bar beside that map that says which colour is which disparity",                       \
     .needs = "color"}

/* What the rows say, by their arguments. */
typedef struct map_options {
    const char *output, *scale, *color, *palette, *scale_bar;
} map_options;

typedef struct map_request {
    const char *output;
    char *colour; /* the name of the second map; NULL = none. The budget owns it */
    colouring colours;
    map_format format;
    uint32_t scale;
    output *files[2]; /* after map_request_open */
} map_request;

/* Reads the arguments of the rows. Returns DONE, BAD_USAGE or NO_RESOURCE. */
int map_request_read(const map_options *given, budget *limit, map_request *asked);

/* Reads the argument of --scale. Returns DONE or BAD_USAGE. */
int map_scale_read(const char *text, uint32_t *scale);

/* The bytes that making and writing the map takes, the map itself too: to be asked for before the
 * work whose result it shows. */
uint64_t map_bytes(const map_request *asked, const qs_labels *labels);

/* Opens the outputs of the request. Returns what job_open_output does. */
int map_request_open(map_request *asked, job *at);

/* Writes the map into them. Returns DONE, BAD_INPUT or NO_RESOURCE. */
int map_request_write(const map_request *asked, const pixel_map *map);

/* Prints the names of the files as keys of JSON. */
void map_request_json(const map_request *asked);

#endif
