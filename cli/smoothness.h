/* The options that say how smooth a labelling is to be, for the problems that have them. Each
 * function returns DONE or BAD_USAGE, and has printed why. */
#ifndef SMOOTHNESS_H
#define SMOOTHNESS_H

#include "qstereo.h"

/* Reads the argument of --lambda.
 *
 * most_scale  the largest denominator that the problem can hold
 * scale       out: integer units in one real unit, so that lambda is whole
 * weight      out: lambda * scale */
int lambda_read(const char *text, uint32_t most_scale, uint32_t *scale, int32_t *weight);

/* Reads the arguments of --smoothness and --truncation (NULL = none). */
int smoothness_read(const char *name, const char *truncation, qs_pairwise *pairwise);

#endif
