/* Segmentation: from its options, a picture and strokes on it to a labelling problem. */
#ifndef SEGMENTING_H
#define SEGMENTING_H

#include "made.h"

/* Rows for a table of options, one behind the other. */
enum { SEGMENTING_LAMBDA, SEGMENTING_CLASSES, SEGMENTING_COSTS, SEGMENTING_OPTIONS };
#define SEGMENTING_OPTION_ROWS                                                                     \
    {"lambda", 0, false, "L", "10", "weight of the smoothness, an exact decimal number"},          \
        {"classes",                                                                                \
         0,                                                                                        \
         false,                                                                                    \
         "N",                                                                                      \
         NULL,                                                                                     \
         "number of classes (default that of the strokes, at least 2); one without strokes "       \
         "begins with the colours of all pixels without strokes"},                                 \
        {"costs",                                                                                  \
         0,                                                                                        \
         false,                                                                                    \
         "C.npy",                                                                                  \
         NULL,                                                                                     \
         "costs of the classes at each pixel, H x W x classes, instead of those of colours; "      \
         "then STROKES can be left out"}

typedef struct segmenting {
    const char *photo, *strokes, *costs; /* names of the files; one of the last two can be NULL */
    qs_segment segment;
    void *workspace; /* after segmenting_open: for qs_segment_refit */
} segmenting;

extern const maker segmenting_maker;

#endif
