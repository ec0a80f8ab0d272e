/* What match does with a map after the labels are found, and what it says of each pixel. Each
 * function returns an exit status and has printed why it failed. */
#ifndef AFTER_H
#define AFTER_H

#include "command.h"
#include "pair.h"
#include "pictures/disparity_map.h"
#include "right_side.h"
#include "solving.h"

/* Rows for a table of options, one behind the other. */
enum { AFTER_STEPS, AFTER_CONFIDENCE, AFTER_MASK, AFTER_OPTIONS };
#define AFTER_OPTION_ROWS                                                                          \
    {"after",                                                                                      \
     0,                                                                                            \
     false,                                                                                        \
     "LIST",                                                                                       \
     NULL,                                                                                         \
     "what follows the labels: halves or refine, check, fill, median in this order, or none "      \
     "(paper: none)"},                                                                             \
        {"confidence", 0,                                                                          \
         false,        "C",                                                                        \
         NULL,         "picture (.png, .pgm) of how sure each pixel is: 0 no value, 255 sure"},    \
        {"mask",                                                                                   \
         0,                                                                                        \
         false,                                                                                    \
         "M",                                                                                      \
         NULL,                                                                                     \
         "picture (.png, .pgm) of the values that were matched (255), not filled or missing"}

typedef struct after {
    const char *steps; /* as given, or as the preset says */
    bool halves, refine, check, fill, median;
    const char *confidence, *mask; /* names of pictures; NULL = not wanted */
    bool confidence_png, mask_png;
    output *files[2]; /* of these, after after_open */
} after;

/* Reads the arguments of the rows. Returns DONE or BAD_USAGE. */
int after_read(const char *const *values, const pair *asked, after *read);

/* Opens the outputs. */
int after_open(after *asked, job *at);

/* Makes the map of the left side and does with it what was asked; writes the pictures that were
 * asked for.
 *
 * right  what was found for the right picture. If it has no labelling yet, it is solved here, as
 *        the left picture's problem was, if the map is to be checked */
int after_labels(const after *asked, const pair *of, const side *left, const solver *by,
                 const search *how, budget *limit, side *right, pixel_map *map);

#endif
