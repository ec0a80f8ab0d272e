/* The options that say which problem a stereo pair is turned into. */
#ifndef PAIR_OPTIONS_H
#define PAIR_OPTIONS_H

#include "pair.h"

/* Rows for a table of options, one behind the other. */
enum {
    PAIR_DISPARITY,
    PAIR_LAMBDA,
    PAIR_ROI,
    PAIR_COST,
    PAIR_SMOOTHNESS,
    PAIR_TRUNCATION,
    PAIR_OPTIONS
};
#define PAIR_OPTION_ROWS                                                                           \
    {"disparity", 0,      false,                                                                   \
     "MIN:MAX",   "0:15", "disparities to choose from, in pixels, both included"},                 \
        {"lambda", 0, false, "L", "20", "weight of the smoothness, an exact decimal number"},      \
        {"roi",     0,    false,                                                                   \
         "X,Y,W,H", NULL, "window of the left picture to match (default all of it)"},              \
        {"cost", 0,    false,                                                                      \
         "NAME", "ad", "cost of a disparity: ad, the absolute difference of the greys"},           \
        {"smoothness", 0,       false,                                                             \
         "NAME",       "potts", "cost of neighbours that differ: potts, linear or quadratic"},     \
        {"truncation", 0,    false,                                                                \
         "T",          NULL, "most that linear or quadratic smoothness reaches (default no bound)"}

/* Reads the arguments of the rows. `weights` names the options that coefficients grow with, for
 * messages; strings are borrowed. Returns DONE or BAD_USAGE. */
int pair_read(const char *left, const char *right, const char *const *values, const char *weights,
              pair *asked);

#endif
