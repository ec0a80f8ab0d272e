/* A problem made smaller by proof: what reduce and encode --reduce share. */
#ifndef REDUCING_H
#define REDUCING_H

#include "solving.h"

/* Rows for a table of options, one behind the other. */
enum { REDUCING_TARGET, REDUCING_TIME_LIMIT, REDUCING_OPTIONS };
#define REDUCING_OPTION_ROWS                                                                       \
    {"target",                                                                                     \
     0,                                                                                            \
     false,                                                                                        \
     "N",                                                                                          \
     NULL,                                                                                         \
     "stop at the first problem of at most N variables (default go on to the proof)",              \
     .needs = "reduce"},                                                                           \
        {"time-limit",                                                                             \
         0,                                                                                        \
         false,                                                                                    \
         "SECONDS",                                                                                \
         NULL,                                                                                     \
         "stop after SECONDS with what has been proven by then (default no limit)",                \
         .needs = "reduce"}

typedef struct reducing {
    uint64_t target; /* variables; 0 = none */
    int64_t time_limit; /* microseconds; 0 = none */
    uint64_t iterations; /* 0 = the library's own limit */
    qs_encoding into; /* the encoding that the problem will be written in */
    const qs_witness *witness; /* of the proof; NULL = none */
    trace *traced; /* its course; NULL = nobody asks for it */
    const uint16_t *start; /* labels of the model's sites to begin with; NULL = none */
} reducing;

/* Reads the arguments of the rows for a problem that will be written in the encoding `into`.
 * Returns DONE or BAD_USAGE. */
int reducing_read(const char *const *values, qs_encoding into, reducing *asked);

typedef struct reduced {
    qs_reduction found; /* if only one labelling is left, its energy is the lower bound too */
    uint64_t target; /* as asked; 0 = none */
    uint64_t most; /* iterations that it might do */
    bool out_of_time; /* the time limit stopped it */
    int64_t microseconds;
    uint8_t *kept; /* as of qs_reduce; the budget owns it */
    uint16_t *labelling; /* of the problem's sites; the budget owns it */
} reduced;

/* The bytes that reduce_problem takes. */
uint64_t reduce_bytes(const laid_out *problem);

/* Reduces the problem. `kept` stays in memory of the budget, the work does not. Returns DONE or
 * NO_RESOURCE, and has printed why. */
int reduce_problem(const laid_out *problem, const reducing *asked, budget *limit, reduced *made);

/* Print what became of the problem `before`, which is now the file `after`: keys of JSON, and lines
 * for people. `form` says in these lines what the variables before are: their encoding, or how
 * they are counted. */
void reduced_json(const reduced *made, const laid_out *before, const problem_file *after);
void reduced_print(const reduced *made, const laid_out *before, const char *form,
                   const problem_file *after);

#endif
