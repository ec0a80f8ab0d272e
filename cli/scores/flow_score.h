/* Fields of displacements beside the truth. */
#ifndef FLOW_SCORE_H
#define FLOW_SCORE_H

#include "fields/flow_file.h"

/* Over the pixels that are known in both (Baker et al., "A database and evaluation methodology for
 * optical flow", IJCV 92, 2011, section 4.1). */
typedef struct flow_score {
    uint64_t pixels; /* 0 = the errors are not set */
    double aepe; /* mean length of the difference, in pixels */
    double aae; /* mean angle between (dx, dy, 1) of both, in degrees (Barron, Fleet and Beauchemin
                   1994) */
} flow_score;

/* Compares two fields of one size. */
void flow_score_find(const flow_field *field, const flow_field *truth, flow_score *found);

/* Print the scores: keys of JSON, and a line for people. */
void flow_score_json(const flow_score *shown);
void flow_score_print(const flow_score *shown);

#endif
