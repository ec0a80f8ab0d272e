/* The disparity map that a command writes, with its map in colours: the options, and a labelling
 * made into files. Each function that returns a status has said why it failed. */
#ifndef MAP_OUTPUT_H
#define MAP_OUTPUT_H

#include "disparity_map.h"
#include "inputs.h"
#include "output.h"

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
