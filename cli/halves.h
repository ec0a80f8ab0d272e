/* A labelling of whole pixels made one of half pixels. */
#ifndef HALVES_H
#define HALVES_H

#include "pair.h"

/* What was found. */
typedef struct halves {
    qs_labels labels; /* two to a pixel */
    uint16_t *labelling; /* the budget owns it */
} halves;

/* Gives each site its disparity, or half a pixel more or less: qs_near with the same costs and
 * smoothness for half pixels. Returns DONE, BAD_INPUT or NO_RESOURCE, and has printed why.
 *
 * of         the problem's pictures and costs, for whole pixels
 * labelling  of the problem */
int halves_make(const char *name, const qs_matching *of, const qs_pairwise *pairwise,
                const uint16_t *labelling, budget *limit, halves *made);

/* The bytes that it takes, about. */
uint64_t halves_bytes(const qs_problem *problem);

#endif
