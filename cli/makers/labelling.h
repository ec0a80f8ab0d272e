/* Any labelling problem: from its options and arrays to the problem. */
#ifndef LABELLING_H
#define LABELLING_H

#include "arrays/units.h"
#include "made.h"

/* Rows for a table of options, one behind the other. */
enum {
    LABELLING_SMOOTHNESS,
    LABELLING_TRUNCATION,
    LABELLING_LAMBDA,
    LABELLING_PAIRWISE,
    LABELLING_WEIGHTS,
    LABELLING_TABLES,
    LABELLING_EDGES,
    LABELLING_MASK,
    LABELLING_SCALE,
    LABELLING_OPTIONS
};
#define LABELLING_OPTION_ROWS                                                                      \
    {"smoothness",                                                                                 \
     0,                                                                                            \
     false,                                                                                        \
     "NAME",                                                                                       \
     NULL,                                                                                         \
     "cost V of neighbours that differ: potts, linear or quadratic "                               \
     "(default potts)"},                                                                           \
        {"truncation", 0,    false,                                                                \
         "T",          NULL, "upper bound of linear or quadratic smoothness (default no bound)"},  \
        {"lambda", 0, false, "L", "1", "weight of all edges, an exact decimal number"},            \
        {"pairwise", 0,    false,                                                                  \
         "V.npy",    NULL, "cost of each two labels, K x K, instead of --smoothness"},             \
        {"weights",                                                                                \
         0,                                                                                        \
         false,                                                                                    \
         "W.npy",                                                                                  \
         NULL,                                                                                     \
         "weights of the edges, lambda times: RIGHT.npy,DOWN.npy of H x (W-1) "                    \
         "and (H-1) x W, or with --edges one array of M"},                                         \
        {"tables",                                                                                 \
         0,                                                                                        \
         false,                                                                                    \
         "T.npy",                                                                                  \
         NULL,                                                                                     \
         "a table for each edge instead of --smoothness: as --weights, with K x "                  \
         "K behind"},                                                                              \
        {"edges", 0,    false,                                                                     \
         "E.npy", NULL, "M x 2 sites: the graph is no grid, and COSTS.npy is N x K"},              \
        {"mask", 0, false, "MASK", NULL, "cells where this picture or .npy is 0 are no sites"},    \
        {"scale",                                                                                  \
         0,                                                                                        \
         false,                                                                                    \
         "S",                                                                                      \
         NULL,                                                                                     \
         "whole units in 1: float arrays are rounded to 1/S (default 1, with a warning if that "   \
         "loses anything)"}

typedef struct labelling_request {
    const char *costs_path;
    const char *const *values; /* of the rows */
    uint32_t scale, factor; /* units in 1: floats are rounded to 1/scale; scale x factor is the
                               problem's scale, which lambda needs */
    int32_t weight; /* lambda in the problem's units */
    bool whole_lambda; /* lambda has no fraction */
    qs_pairwise pairwise;
    npy_array costs, right_tables, down_tables;
    units cost_units, table_units;
} labelling_request;

extern const maker labelling_maker;

#endif
