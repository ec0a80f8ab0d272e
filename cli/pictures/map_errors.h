/* How far a disparity map is from the truth: the errors of the paper. Each function that can fail
 * returns an exit status and has printed why. */
#ifndef MAP_ERRORS_H
#define MAP_ERRORS_H

#include "pictures/disparity_map.h"

enum { ERROR_RMS, ERROR_BAD_HALF, ERROR_BAD_ONE, ERRORS };

typedef struct map_errors {
    uint64_t pixels; /* with a value in both maps; if there are none, the errors are not set */
    double of[ERRORS];
} map_errors;

/* Compares two maps. Returns DONE, or BAD_INPUT if their sizes differ. */
int map_errors_find(const char *name, const qs_map *map, const char *truth_name,
                    const qs_map *truth, map_errors *found);

/* Print the errors: keys of JSON, and lines for people. */
void map_errors_json(const map_errors *shown);
void map_errors_print(const map_errors *shown);

/* Rows for a table of options. */
#define TRUTH_OPTION                                                                               \
    {"truth", 0, false, "TRUTH", NULL, "score against this true disparity map of the left picture"}
#define TRUTH_SCALE_OPTION                                                                         \
    {"truth-scale", 0, false, "S", "8", "TRUTH holds disparity x S; a .pfm always holds pixels"}

/* A true map that maps are compared with as they are made. */
typedef struct true_map {
    const char *name;
    qs_map map;
} true_map;

/* Reads the argument of --truth-scale. Returns DONE or BAD_USAGE. */
int truth_scale_read(const char *text, uint32_t *scale);

/* Reads a true map for pictures of a size into memory of the budget. Returns DONE, BAD_INPUT or
 * NO_RESOURCE. */
int truth_open(const char *path, uint32_t scale, uint32_t width, uint32_t height, budget *limit,
               true_map *opened);

/* Compares a map with the truth. Returns DONE. */
int truth_compare(const true_map *with, const pixel_map *map, map_errors *found);

#endif
