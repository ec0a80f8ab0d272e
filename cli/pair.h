/* A stereo pair: from its options and the names of two pictures to a labelling problem. */
#ifndef PAIR_H
#define PAIR_H

#include "inputs.h"

/* A stereo pair: from the names of two pictures to a labelling problem and the bytes of its .qcf.
 * Each function returns DONE, BAD_INPUT or NO_RESOURCE, having said why. */

typedef struct pair {
    const char *left, *right; /* names of the pictures */
    const char *weights; /* the options that coefficients grow with */
    bool whole; /* no window was given */
    qs_stereo stereo;
    qs_pairwise pairwise;
    uint8_t *left_pixels, *right_pixels;
    void *workspace;
} pair;

/* Reads the pictures and makes the problem, which borrows the pair. pair_close frees what was
 * allocated in any case. */
int pair_open(pair *opened, qs_problem *problem);
void pair_close(pair *closed);

/* Writes the problem as a .qcf; size may be NULL. Bytes that the sink refuses are no failure here:
 * its owner knows of them. */
int pair_encode(const pair *encoded, const qs_problem *problem, const qs_encode_options *options,
                const qs_sink *sink, uint64_t *size);

/* The same in memory, opened, under the name of the left picture. problem_close frees what was
 * allocated in any case. */
int pair_hold(const pair *held, const qs_problem *problem, const qs_encode_options *options,
              budget *limit, problem_file *made);

/* The options that say which problem a stereo pair is turned into. */

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
