/* A labelling of whole pixels made one of half pixels. */
#ifndef HALVES_H
#define HALVES_H

#include "pair.h"

/* In three steps, so that two of them can be made at the same time, and what cannot be made is
 * known before the labelling is looked for. */
typedef struct halves {
    const char *name; /* for messages */
    qs_problem problem; /* with twice the labels */
    qs_labels labels; /* two to a pixel */
    uint16_t *labelling; /* the budget owns it, and what the problem borrows */
    qs_status made;
} halves;

/* Makes the problem: the same costs and smoothness for half pixels. Returns DONE, BAD_INPUT or
 * NO_RESOURCE, and has printed why.
 *
 * of  the pictures and costs, for whole pixels */
int halves_begin(const char *name, const qs_matching *of, const qs_pairwise *pairwise,
                 budget *limit, halves *begun);

/* The bytes of workspace of halves_do. */
size_t halves_workspace(const halves *begun);

/* Gives each site its disparity, or half a pixel more or less: qs_near. Any thread may: it takes no
 * memory and prints no message.
 *
 * labelling  of whole pixels */
void halves_do(halves *begun, const uint16_t *labelling, void *workspace, size_t size);

/* Returns DONE, or BAD_INPUT and has printed why. */
int halves_check(const halves *done);

/* The bytes that all of it takes, about. */
uint64_t halves_bytes(const qs_problem *problem);

#endif
