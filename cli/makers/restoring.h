/* Restoration: from its options and a noisy picture to a labelling problem. */
#ifndef RESTORING_H
#define RESTORING_H

#include "made.h"

/* Rows for a table of options, one behind the other. */
enum {
    RESTORING_LAMBDA,
    RESTORING_COST,
    RESTORING_SMOOTHNESS,
    RESTORING_TRUNCATION,
    RESTORING_STEP,
    RESTORING_HOLE,
    RESTORING_OPTIONS
};
#define RESTORING_OPTION_ROWS                                                                      \
    {"lambda", 0, false, "L", "1", "weight of the smoothness, an exact decimal number"},           \
        {"cost",                                                                                   \
         0,                                                                                        \
         false,                                                                                    \
         "NAME",                                                                                   \
         "squared",                                                                                \
         "cost of a grey v at a pixel I: absolute, |I - v|, for impulses; "                        \
         "squared, (I - v)^2, for Gaussian noise"},                                                \
        {"smoothness", 0,           false,                                                         \
         "NAME",       "quadratic", "cost of neighbours that differ: potts, linear or quadratic"}, \
        {"truncation", 0,    false,                                                                \
         "T",          NULL, "upper bound of linear or quadratic smoothness (default no bound)"},  \
        {"step", 0,   false,                                                                       \
         "G",    "1", "labels are the greys 0, G, 2G, ...; the smoothness counts steps"},          \
        {"hole", 0,    false,                                                                      \
         "MASK", NULL, "fill the pixels where this picture is not 0: their greys do not count"}

typedef struct restoring {
    const char *noisy, *mask; /* names of the pictures; NULL = no hole */
    qs_restore restore;
} restoring;

extern const maker restoring_maker;

#endif
