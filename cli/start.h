/* A labelling to begin with: the best sample of a file, or what the problem's file carries. */
#ifndef START_H
#define START_H

#include "command.h"
#include "solving.h"

/* A row for a table of options. */
#define START_OPTION                                                                               \
    {"start",                                                                                      \
     0,                                                                                            \
     false,                                                                                        \
     "START.qsf",                                                                                  \
     NULL,                                                                                         \
     "samples of P.qcf: begin with the best one; the answer is not above it "                      \
     "(default the labelling that P.qcf carries, if it has one)"}

/* Reads the samples of the problem that is open and laid out, and takes the best feasible one.
 *
 * path   NULL = the best labelling known that the problem's file carries, if it has one
 * start  out: labels of the model's sites, in memory of the budget; NULL if there is no start
 *
 * Returns DONE, BAD_INPUT or NO_RESOURCE, and has printed why. */
int start_read(job *at, const char *path, const laid_out *problem, const uint16_t **start);

#endif
