/* Pairwise Markov networks in the UAI format (the file formats of the UAI 2008 competition;
 * "MARKOV" networks), as labelling problems: the cost of a factor's entry is -log of it. */
#ifndef UAI_H
#define UAI_H

#include "made.h"

/* Rows for a table of options, one behind the other. */
enum { UAI_SCALE, UAI_OPTIONS };
#define UAI_OPTION_ROWS                                                                            \
    {"scale",                                                                                      \
     0,                                                                                            \
     false,                                                                                        \
     "S",                                                                                          \
     "1000",                                                                                       \
     "whole units in 1: costs, -log of factors, are rounded "                                      \
     "to 1/S"}

typedef struct uai_network {
    const char *path;
    uint32_t scale;
} uai_network;

extern const maker uai_maker;

#endif
