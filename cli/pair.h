/* A stereo pair: from its options and the names of two pictures to a labelling problem. Each
 * function that can fail returns an exit status and has printed why. */
#ifndef PAIR_H
#define PAIR_H

#include "made.h"

/* Rows for a table of options, one behind the other. */
enum {
    PAIR_DISPARITY,
    PAIR_LAMBDA,
    PAIR_ROI,
    PAIR_COST,
    PAIR_SMOOTHNESS,
    PAIR_TRUNCATION,
    PAIR_BITS,
    PAIR_OPTIONS
};
#define PAIR_OPTION_ROWS                                                                           \
    {"disparity", 0,      false,                                                                   \
     "MIN:MAX",   "0:15", "disparities in pixels, both included; they may be below 0"},            \
        {"lambda", 0, false, "L", "20", "weight of the smoothness, an exact decimal number"},      \
        {"roi",     0,    false,                                                                   \
         "X,Y,W,H", NULL, "window of the left picture to match (default all of it)"},              \
        {"cost", 0,    false,                                                                      \
         "NAME", "ad", "cost of a disparity: ad, the absolute difference of the greys"},           \
        {"smoothness", 0,       false,                                                             \
         "NAME",       "potts", "cost of neighbours that differ: potts, linear or quadratic"},     \
        {"truncation", 0,    false,                                                                \
         "T",          NULL, "upper bound of linear or quadratic smoothness (default no bound)"},  \
        {"bits", 0, false, "N", NULL, "the pictures hold N bits in files of 16: white is 2^N - 1"}

typedef struct pair {
    const char *left, *right; /* names of the pictures */
    unsigned bits; /* of the samples of a file of 16; 0 = all */
    bool whole; /* no window was given */
    qs_stereo stereo;
    qs_pairwise pairwise;
} pair;

extern const maker pair_maker;

/* Reads the arguments of the rows; strings are borrowed. Returns DONE or BAD_USAGE. */
int pair_read(const char *const *operands, const char *const *values, void *asked);

/* Reads the pictures and makes the problem, which borrows from the budget. Returns DONE, BAD_INPUT
 * or NO_RESOURCE. */
int pair_open(void *asked, budget *limit, made_problem *opened);

/* Prints how many columns the problem leaves out on each side. */
void pair_print_outside(const pair *asked, const qs_problem *made);

#endif
