/* Flow and registration: from their options and two pictures to a labelling problem. */
#ifndef DISPLACING_H
#define DISPLACING_H

#include "fields/flow_file.h"
#include "made.h"

/* Rows for a table of options, one behind the other, with their defaults. */
enum {
    DISPLACING_LAMBDA,
    DISPLACING_TRUNCATION,
    DISPLACING_STEP,
    DISPLACING_WINDOW,
    DISPLACING_RADIUS,
    DISPLACING_UNIT,
    DISPLACING_OPTIONS
};
#define DISPLACING_OPTION_ROWS(lambda, truncation, step, window, radius, unit)                     \
    {"lambda", 0,      false,                                                                      \
     "L",      lambda, "weight of the smoothness, in grey levels a pixel of difference"},          \
        {"truncation", 0,          false,                                                          \
         "T",          truncation, "upper bound of the smoothness, in pixels; 0 = none"},          \
        {"step",                                                                                   \
         0,                                                                                        \
         false,                                                                                    \
         "S",                                                                                      \
         step,                                                                                     \
         "pixels between sites; between them the field is "                                        \
         "interpolated"},                                                                          \
        {"window", 0, false, "W", window, "side of the square that is compared, in pixels; odd"},  \
        {"radius", 0, false, "R", radius, "largest displacement in pixels; RX,RY if it differs"},  \
        {"fraction", 0,    false,                                                                  \
         "N",        unit, "displacements are multiples of 1/N pixel, N from 1 to 16"}
#define FLOW_OPTION_ROWS     DISPLACING_OPTION_ROWS("2", "8", "4", "9", "4", "1")
#define REGISTER_OPTION_ROWS DISPLACING_OPTION_ROWS("0.2", "0", "10", "13", "6", "2")

typedef struct displacing {
    const char *first, *second; /* names of the pictures */
    qs_displace displace;
} displacing;

extern const maker displacing_maker;

/* Reads the true field, which is as large as the pictures. Returns DONE, BAD_INPUT or
 * NO_RESOURCE. */
int displacing_truth_read(const displacing *asked, const char *path, budget *limit,
                          flow_field *truth);

#endif
