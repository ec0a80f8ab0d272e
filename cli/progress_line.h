/* A solver at work: how long it may take, and a line on the terminal that shows how far it is. */
#ifndef PROGRESS_LINE_H
#define PROGRESS_LINE_H

#include "qstereo.h"
#include "trace.h"

typedef struct progress {
    const char *solver;
    uint32_t scale;
    int64_t begin; /* microseconds, as all times here */
    int64_t end; /* when it is to stop; 0 = at no time */
    double gap; /* it stops when the gap is this small, in percent; negative = at none */
    trace *traced; /* gets a row for each change; NULL = none */
    int64_t next; /* when the line is written again */
    bool terminal; /* standard error is one */
    bool shown; /* the line was written */
    bool out_of_time; /* the solver was told to stop */
    bool in_gap; /* it was told so because of the gap */
    bool interrupted; /* by a signal that was kept */
} progress;

/* Microseconds on a clock that never goes back. */
int64_t progress_clock(void);

/* Says when the command began. Once, first of all. */
void progress_start_command(void);

/* The same at the beginning of a part of a command whose time is counted apart. */
void progress_start_part(void);

/* Microseconds since then. */
int64_t progress_since_command(void);

/* Starts the clock of a solver.
 *
 * limit  0 = none
 * whole  the limit is that of the whole command, else of this solver */
progress progress_begin(const char *solver, uint32_t scale, int64_t limit, bool whole);

/* While it is on, the first SIGINT or SIGTERM stops the solver instead of the command. */
void progress_keep_on_interrupt(bool on);

/* Returns true if the signal stops the solver. A signal handler may call it. */
bool progress_takes_signal(int signal_number);

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
