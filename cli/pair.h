/* A stereo pair: from the names of two pictures to a labelling problem and the bytes of its .qcf.
 * Each function returns DONE, BAD_INPUT or NO_RESOURCE, having said why. */
#ifndef PAIR_H
#define PAIR_H

#include "inputs.h"

typedef struct pair {
    const char *left, *right; /* names of the pictures */
    const char *weights; /* the options that coefficients grow with */
    bool whole; /* no window was given */
    qs_stereo stereo;
    qs_pairwise pairwise;
    uint8_t *left_pixels, *right_pixels;
    void *workspace;
} pair;

/* Reads the pictures and makes the problem, which borrows the pair. pair_close frees what was
 * allocated in any case. */
int pair_open(pair *opened, qs_problem *problem);
void pair_close(pair *closed);

/* Writes the problem as a .qcf; size may be NULL. Bytes that the sink refuses are no failure here:
 * its owner knows of them. */
int pair_encode(const pair *encoded, const qs_problem *problem, const qs_encode_options *options,
                const qs_sink *sink, uint64_t *size);

/* The same in memory, opened, under the name of the left picture. problem_close frees what was
 * allocated in any case. */
int pair_hold(const pair *held, const qs_problem *problem, const qs_encode_options *options,
              budget *limit, problem_file *made);

#endif
