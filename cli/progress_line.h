/* A solver at work: how long it may take, and a line on the terminal that shows how far it is. */
#ifndef PROGRESS_LINE_H
#define PROGRESS_LINE_H

#include "qstereo.h"

typedef struct progress {
    const char *solver;
    uint32_t scale;
    int64_t begin; /* microseconds, as all times here */
    int64_t limit; /* 0 = none */
    int64_t next; /* when the line is written again */
    bool terminal; /* standard error is one */
    bool shown; /* the line was written */
    bool out_of_time; /* the solver was told to stop */
} progress;

/* Starts the clock. */
progress progress_begin(const char *solver, uint32_t scale, int64_t limit);

/* The qs_watch of a progress: writes the line, and stops the solver when its time is over. */
bool progress_watch(void *context, const qs_progress *now);

/* How much of the time is over, for qs_solve_options. There is a limit. */
uint32_t progress_spent(void *context);

/* The same for a reduction: its qs_reduce_watch. */
bool progress_watch_reduction(void *context, const qs_reduction *now);

/* Clears the line. Returns the microseconds since the beginning. */
int64_t progress_end(progress *ended);

/* Clears the line. A signal handler may call it. */
void progress_interrupt(void);

#endif
