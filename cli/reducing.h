/* A problem made smaller by proof: what reduce and encode --reduce share. */
#ifndef REDUCING_H
#define REDUCING_H

#include "solving.h"

/* Rows for a table of options, one behind the other. */
enum { REDUCING_TARGET, REDUCING_TIME_LIMIT, REDUCING_OPTIONS };
#define REDUCING_OPTION_ROWS                                                                       \
    {"target", 0,                                                                                  \
     false,    "N",                                                                                \
     NULL,     "stop at the first problem of at most N variables (default go on to the proof)"},   \
        {"time-limit", 0,                                                                          \
         false,        "S",                                                                        \
         NULL,         "stop after S seconds with what has been proven by then (default no limit)"}

typedef struct reducing {
    uint64_t target; /* variables; 0 = none */
    int64_t time_limit; /* microseconds; 0 = none */
    uint64_t iterations; /* 0 = the library's own limit */
    qs_encoding into; /* what the problem will be written in */
} reducing;

/* Reads the arguments of the rows for a problem that will be written in the encoding `into`.
 * Returns DONE or BAD_USAGE. */
int reducing_read(const char *const *values, qs_encoding into, reducing *asked);

typedef struct reduced {
    qs_reduction found; /* where one labelling alone is left, its energy is the lower bound too */
    uint64_t target; /* as asked; 0 = none */
    bool out_of_time; /* the time limit stopped it */
    int64_t microseconds;
    uint8_t *kept; /* as of qs_reduce; to be freed */
} reduced;

/* Returns DONE or NO_RESOURCE, having said why; reduced_free frees what was allocated in any case.
 * The limit is for the work alone, but for `kept`. */
int reduce_problem(const laid_out *problem, const reducing *asked, budget *limit, reduced *made);
void reduced_free(reduced *freed);

/* What became of the problem `before`, in the file `after`: keys of JSON, and lines for people,
 * which say `form` of what the variables before are: their encoding, or how they are counted where
 * that is of no interest. */
void reduced_json(const reduced *made, const problem_file *before, const problem_file *after);
void reduced_print(const reduced *made, const problem_file *before, const char *form,
                   const problem_file *after);

#endif
