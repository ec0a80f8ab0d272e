/* The options that say what a match costs and which labels there are. Each function returns DONE or
 * BAD_USAGE, and has printed why. */
#ifndef MATCHING_READ_H
#define MATCHING_READ_H

#include "qstereo.h"

/* MIN:MAX, or MIN:MAX:STEP with STEP 1 or 0.5.
 *
 * step  that of the preset, if there is none */
int disparity_range_read(const char *text, const char *step, qs_matching *matching);

/* A sum of terms: ad|sd|bt:40+2*census:7x7. */
int cost_read(const char *text, qs_matching *matching);

/* BELOW,TIMES; NULL = none. */
int contrast_read(const char *text, qs_matching *matching);

/* keep or leave-out, after cost_read. */
int border_read(const char *text, qs_matching *matching);

#endif
