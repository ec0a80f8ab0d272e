/* A solver at work: how long it may take, and a line on the terminal that says how far it is. */
#ifndef PROGRESS_H
#define PROGRESS_H

#include "qstereo.h"

typedef struct progress {
    const char *solver;
    uint32_t scale;
    int64_t begin, limit,
        next; /* microseconds; limit 0 = none; next: when the line is to be written again */
    bool terminal, shown;
    bool out_of_time; /* the solver was told to stop */
} progress;

/* Starts the clock. */
progress progress_begin(const char *solver, uint32_t scale, int64_t limit);

/* Tells the solver to stop when its time is over: the qs_watch of a progress. */
bool progress_watch(void *context, const qs_progress *now);

/* The same of a reduction: its qs_reduce_watch. */
bool progress_watch_reduction(void *context, const qs_reduction *now);

/* Clears the line. Returns the microseconds since the beginning. */
int64_t progress_end(progress *ended);

/* Clears the line, from a signal's handler. */
void progress_interrupt(void);

#endif
