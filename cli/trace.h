/* The course of a solver as a file of CSV: a row whenever its energy, its bound or the variables
 * that are left have changed, and one at its end.
 *
 *     solver,seconds,iteration,energy,bound,variables
 *
 * Seconds count from the solver's beginning. What a solver does not know is empty. */
#ifndef TRACE_H
#define TRACE_H

#include <stdbool.h>
#include <stdint.h>

#include "qstereo.h"

struct job;
struct output;

/* A row for a table of options. */
#define TRACE_OPTION                                                                               \
    {"trace", 0, false, "T.csv", NULL, "also write how energy and bound went on, second by second"}

/* What a row says. */
typedef struct trace_point {
    int64_t microseconds;
    uint64_t iteration;
    int64_t energy;
    int64_t bound; /* QS_NO_BOUND = none */
    uint64_t variables; /* of what is left; TRACE_NO_VARIABLES = the solver takes nothing out */
} trace_point;

#define TRACE_NO_VARIABLES UINT64_MAX

typedef struct trace {
    struct output *out; /* NULL = no trace is asked for, and nothing is written */
    const char *solver;
    uint32_t scale; /* integer units in one real unit */
    bool begun; /* the solver has a row */
    trace_point last; /* its last one */
} trace;

/* Opens the file and writes the heading.
 *
 * path  NULL = no trace
 *
 * Returns what job_open_beside does. */
int trace_open(struct job *at, const char *path, uint32_t scale, trace *made);

/* The rows from here on are of this solver; the name is borrowed. */
void trace_begin(trace *to, const char *solver);

/* Writes a row if it tells something new. A NULL trace takes none. */
void trace_add(trace *to, const trace_point *now);

/* Writes the last row of the solver. */
void trace_end(trace *to, const trace_point *now);

#endif
