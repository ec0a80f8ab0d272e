/* Disparity maps: as files, in colours, and as what a command writes. */
#ifndef MAP_H
#define MAP_H

#include <stdint.h>

#include "inputs.h"
#include "output.h"
#include "pictures/picture.h"
#include "qstereo.h"

/* Disparity maps as files: integers (disparity * scale, 0 = no value) in .pgm and .png, or pixels
 * as floats in .pfm. */

/* The scale at which the floats of a PFM are held. */
#define PFM_SCALE 65536u

/* Reads a map; `scale` is that of an integer one, a PFM is in pixels. Returns DONE, BAD_INPUT or
 * NO_RESOURCE, having said why. The values are to be freed. */
int map_read(const char *path, uint32_t scale, qs_map *map, int32_t **values);

typedef enum map_format { MAP_PGM, MAP_PNG, MAP_PFM } map_format;

/* The format that an output's name asks for; `straight`: it may have no ending, then PGM. Returns
 * DONE or BAD_USAGE. */
int map_format_of(const char *path, bool straight, map_format *format);

/* Disparities in pixels, row after row; MAP_NO_VALUE = none. */
#define MAP_NO_VALUE UINT32_MAX
typedef struct pixel_map {
    const uint32_t *disparities;
    uint32_t width, height;
    uint32_t least, most; /* the colours' range */
} pixel_map;

/* The map as the bytes of a file. Returns DONE, BAD_INPUT (a value does not fit) or NO_RESOURCE,
 * having said why. */
int map_encode(const pixel_map *map, map_format format, uint32_t scale, const char *path,
               file_bytes *file);

/* The map in colours, as a PNG where `png`, else as a PPM. */
int map_encode_colour(const pixel_map *map, bool png, const char *path, file_bytes *file);

/* Colours for people: small disparities blue, large ones red, no value black. */

/* The colour of `value` on a scale that ends at `most` (at least `value`). */
void colour_of(uint32_t value, uint32_t most, uint16_t rgb[3]);

/* The disparity map that a command writes, with its map in colours: the options, and a labelling
 * made into files. Each function that returns a status has said why it failed. */

/* Rows for a table of options. */
#define MAP_OUTPUT_OPTION                                                                          \
    {"output", 'o',  true,                                                                         \
     "MAP",    NULL, "the map to write: .png, .pgm or .pfm; - is standard output, PGM"}
#define SCALE_OPTION                                                                               \
    {"scale", 0, false, "S", "8", "a .png or .pgm holds disparity x S, from 2; a .pfm holds pixels"}
#define COLOR_OPTION                                                                               \
    {"color", 0, false, NULL, NULL, "write a map in colours beside it, MAP.color.png (or .ppm)"}

typedef struct map_request {
    const char *output;
    char *colour; /* the second map; NULL = none */
    map_format format;
    uint32_t scale;
} map_request;

/* Reads the arguments of the rows. Returns DONE, BAD_USAGE or NO_RESOURCE; map_request_free frees
 * what was allocated in any case. */
int map_request_read(const char *path, const char *scale, bool color, bool json,
                     map_request *asked);
void map_request_free(map_request *asked);

/* The argument of --scale. Returns DONE or BAD_USAGE. */
int map_scale_read(const char *text, uint32_t *scale);

/* Whether the problem is one that a map can be made of. Returns DONE or BAD_INPUT. */
int map_check_grid(const problem_file *problem);

/* The labels of a grid's sites where the sites are in the picture; map->disparities is
 * `disparities`, from malloc. Returns DONE or NO_RESOURCE. */
int map_of_labelling(const problem_file *problem, const uint16_t *labelling, budget *limit,
                     uint32_t **disparities, pixel_map *map);

/* The outputs that a request names. After DONE they must be committed or abandoned. */
typedef struct map_outputs {
    output outs[2];
    size_t count;
} map_outputs;

int map_outputs_open(const map_request *asked, map_outputs *opened);
int map_outputs_write(const map_request *asked, const pixel_map *map, map_outputs *to);
int map_outputs_commit(map_outputs *to);
void map_outputs_abandon(map_outputs *to);

/* The names of the files, as keys of JSON and for people. */
void map_request_json(const map_request *asked);
void map_request_print(const map_request *asked);

#endif
