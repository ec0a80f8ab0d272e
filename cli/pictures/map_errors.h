/* How far a disparity map is from the truth: the errors of the paper. Each function that can fail
 * returns an exit status and has printed why. */
#ifndef MAP_ERRORS_H
#define MAP_ERRORS_H

#include "pictures/disparity_map.h"

enum { ERROR_RMS, ERROR_BAD_HALF, ERROR_BAD_ONE, ERROR_BAD_TWO, ERROR_AVERAGE, ERROR_D1, ERRORS };

typedef struct map_errors {
    uint64_t pixels; /* with a value in both maps; if there are none, the errors are not set */
    double of[ERRORS];
    double density; /* the share of the truth's pixels that these are, in percent */
} map_errors;

/* Compares two maps. Returns DONE, or BAD_INPUT if their sizes differ. */
int map_errors_find(const char *name, const qs_map *map, const char *truth_name,
                    const qs_map *truth, map_errors *found);

/* Print the errors: keys of JSON, and lines for people: those of the paper, and the others. */
void map_errors_json(const map_errors *shown);
void map_errors_json_more(const map_errors *shown);
void map_errors_print(const map_errors *shown);
void map_errors_print_more(const map_errors *shown);

/* Warns if nearly all pixels are wrong, for then a scale may be wrong. */
void map_errors_warn(const char *name, const map_errors *found);

/* Rows for a table of options. */
#define TRUTH_OPTION                                                                               \
    {"truth", 0, false, "TRUTH", NULL, "score against this true disparity map of the left picture"}
#define TRUTH_SCALE_OPTION                                                                         \
    {"truth-scale",   0, false, "S", "8", "TRUTH holds disparity x S; a .pfm always holds pixels", \
     .needs = "truth"}
#define TRUTH_NO_VALUE_OPTION                                                                      \
    {"truth-no-value", 0, false, "V", NULL, "in TRUTH " NO_VALUE_HELP, .needs = "truth"}

/* A true map that maps are compared with as they are made. */
typedef struct true_map {
    const char *name;
    qs_map map;
} true_map;

/* Reads the arguments of --truth-scale and --truth-no-value. Returns DONE or BAD_USAGE. */
int truth_form_read(const char *scale, const char *no_value, map_form *form);

/* Reads a true map for pictures of a size into memory of the budget. Returns DONE, BAD_INPUT or
 * NO_RESOURCE. */
int truth_open(const char *path, const map_form *form, uint32_t width, uint32_t height,
               budget *limit, true_map *opened);

/* Compares a map with the truth. Returns DONE. */
int truth_compare(const true_map *with, const pixel_map *map, map_errors *found);

#endif
