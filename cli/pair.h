/* A stereo pair: from its options and the names of two pictures to a labelling problem. Each
 * function that can fail returns an exit status and has printed why. */
#ifndef PAIR_H
#define PAIR_H

#include "made.h"
#include "presets.h"

/* Rows for a table of options, one behind the other. */
enum {
    PAIR_DISPARITY,
    PAIR_LAMBDA,
    PAIR_ROI,
    PAIR_COST,
    PAIR_SMOOTHNESS,
    PAIR_TRUNCATION,
    PAIR_BITS,
    PAIR_PRESET,
    PAIR_CONTRAST,
    PAIR_BORDER,
    PAIR_OPTIONS
};
#define PAIR_OPTION_ROWS                                                                           \
    {"disparity",                                                                                  \
     0,                                                                                            \
     false,                                                                                        \
     "MIN:MAX[:STEP]",                                                                             \
     "0:15",                                                                                       \
     "disparities in pixels, both included; they may be below 0; the step is 1 or "                \
     "0.5"},                                                                                       \
        {"lambda", 0, false, "L", NULL, "weight of the smoothness, an exact decimal number"},      \
        {"roi",     0,    false,                                                                   \
         "X,Y,W,H", NULL, "window of the left picture to match (default all of it)"},              \
        {"cost",                                                                                   \
         0,                                                                                        \
         false,                                                                                    \
         "SUM",                                                                                    \
         NULL,                                                                                     \
         "cost of a disparity: ad, sd, bt or census:WxH, as [WEIGHT*]NAME[:TRUNCATION], or two "   \
         "with + between"},                                                                        \
        {"smoothness", 0,    false,                                                                \
         "NAME",       NULL, "cost of neighbours that differ: potts, linear or quadratic"},        \
        {"truncation", 0,    false,                                                                \
         "T",          NULL, "upper bound of linear or quadratic smoothness (default no bound)"},  \
        {"bits", 0, false, "N", NULL, "pictures of N bits in files of 16: white is 2^N - 1"},      \
        {"preset", 0,       false,                                                                 \
         "NAME",   "paper", "settings for what is not given: paper, accurate or fast"},            \
        {"contrast",                                                                               \
         0,                                                                                        \
         false,                                                                                    \
         "G,N",                                                                                    \
         NULL,                                                                                     \
         "N times the weight between pixels whose greys differ by less than G, or none"},          \
        {"border", 0,    false,                                                                    \
         "NAME",   NULL, "pixels whose matches leave the right picture: keep or leave-out"}

/* What the options and the preset say together. */
typedef struct pair_settings {
    const char *cost, *contrast, *border, *smoothness, *lambda, *truncation; /* NULL = none */
} pair_settings;

typedef struct pair {
    const char *left, *right; /* names of the pictures */
    unsigned bits; /* of the samples of a file of 16; 0 = all */
    bool whole; /* no window was given */
    qs_matching stereo;
    qs_pairwise pairwise;
    const preset *from;
    const preset_range *range; /* of from */
    pair_settings settings;
} pair;

extern const maker pair_maker;

/* Reads the arguments of the rows; strings are borrowed. Returns DONE or BAD_USAGE. */
int pair_read(const char *const *operands, const char *const *values, void *asked);

/* Sets the range to 0 .. pixels - 1, and what a preset says for such a range. The same values as
 * above. */
int pair_set_labels(const char *const *values, uint32_t pixels, pair *asked);

/* Makes the problem of pictures that are there already; it borrows from the budget. Returns DONE,
 * BAD_INPUT or NO_RESOURCE. */
int pair_make(pair *asked, budget *limit, made_problem *opened);

/* Makes the problem of a window, in memory of the budget, without messages but for memory. Returns
 * DONE or NO_RESOURCE, and the library's answer. */
int pair_problem(const qs_matching *matching, const char *name, budget *limit, qs_problem *problem,
                 qs_status *made);

/* Prints the settings: keys of JSON. */
void pair_json(const pair *asked);

/* Prints how many columns the problem leaves out on each side. */
void pair_print_outside(const pair *asked, const qs_problem *made);

#endif
