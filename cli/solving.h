/* The solvers by their names, how long they may search, and what they find. Each function that
 * can fail returns an exit status and has printed why. */
#ifndef SOLVING_H
#define SOLVING_H

#include "inputs.h"
#include "trace.h"

/* The options that say how long a solver may search: rows for a table, one behind the other. */
enum { SEARCH_TIME_LIMIT, SEARCH_ITERATIONS, SEARCH_SEED, SEARCH_OPTIONS };
#define SEARCH_OPTION_ROWS                                                                         \
    {                                                                                              \
        "time-limit", 0,                                                                           \
        false,        "SECONDS",                                                                   \
        NULL,         "stop a solver after SECONDS and take its best so far (default no limit)"},  \
        {"iterations", 0,    false,                                                                \
         "N",          NULL, "stop a solver after N iterations (default its own limit)"},          \
        {"seed", 0,   false,                                                                       \
         "N",    "0", "seed of the random numbers of anneal; the same seed gives the same answer"}

typedef struct search {
    int64_t time_limit; /* microseconds; 0 = none */
    uint64_t iterations; /* 0 = the solver's own limit */
    uint64_t seed;
    bool whole_command; /* the time is that of the whole command, else of the solver */
    bool follow_up; /* a solver like this one follows: it gets half of the time */
    double gap; /* percent of the energy; negative = none */
    bool keep_on_interrupt;
    const qs_witness *witness; /* of the proof; NULL = none */
    trace *traced; /* the course of the solver; NULL = nobody asks for it */
    const uint16_t *start; /* labels of the model's sites; NULL = none. The answer is not above
                              them */
} search;

/* More such options, of commands that run one solver. */
enum { STOPPING_GAP_LIMIT, STOPPING_KEEP, STOPPING_OPTIONS };
#define STOPPING_OPTION_ROWS                                                                       \
    {"gap-limit", 0,    false,                                                                     \
     "P%",        NULL, "stop when the energy is within P percent of the lower bound"},            \
        {"keep-on-interrupt",                                                                      \
         0,                                                                                        \
         false,                                                                                    \
         NULL,                                                                                     \
         NULL,                                                                                     \
         "after Ctrl-C stop the solver and keep its best so far"}

/* Reads the arguments of those rows, after search_read. Returns DONE or BAD_USAGE. */
int stopping_read(const char *const *values, search *asked);

/* Reads the arguments of the rows. Returns DONE or BAD_USAGE. */
int search_read(const char *const *values, search *asked);

typedef struct solver {
    const char *name;
    qs_solver *run;
    size_t (*workspace)(const qs_model *model);
    /* Instead of these, of a solver that takes the problem itself. */
    qs_status (*run_straight)(const qs_problem *problem, const qs_solve_options *options,
                              void *workspace, size_t workspace_size, uint16_t *labelling,
                              qs_solution *solution);
    size_t (*straight_workspace)(const qs_problem *problem, uint64_t iterations);
    const char *needs; /* what a problem must have, for messages; NULL = it takes any problem */
} solver;

/* The names of the solvers, one by one; NULL after the last. */
const char *solver_at(size_t index);

/* A row for a table of options. */
#define SOLVER_OPTION                                                                              \
    {"solver", 0,      false,                                                                      \
     "NAME",   "best", "icm, anneal, swap, expansion, bp, trws, cut, pack or best"}

/* The same where a preset chooses it. */
#define PAIR_SOLVER_OPTION                                                                         \
    {"solver", 0,                                                                                  \
     false,    "NAME",                                                                             \
     NULL,     "icm, anneal, swap, expansion, bp, trws, trws16, cut, pack or best (paper: best)"}

/* Reads the argument of --solver, of match in the second case, and one name, `length` letters of
 * `text`, of the argument of --solvers. Return DONE or BAD_USAGE. */
int solver_read(const char *text, const solver **chosen);
int pair_solver_read(const char *text, const solver **chosen);
int solvers_read(const char *text, size_t length, const solver **chosen);

/* A problem laid out for the solvers: that of a file, or one that was never a file. Where the
 * problem is to be solved straight there is no model: it has 0 sites. */
typedef struct laid_out {
    const char *name; /* for messages */
    uint32_t scale; /* integer units in one real unit */
    uint64_t variables; /* of the file, or of the problem as one-hot */
    qs_labels labels;
    qs_model model;
    const problem_file *file; /* indexed; one of these two is NULL */
    const qs_problem *problem;
} laid_out;

/* Lays a problem out in memory of the budget; the file is indexed first. Both are borrowed. Return
 * DONE, BAD_INPUT or NO_RESOURCE.
 *
 * mend  what the user can make smaller if the costs are too large, for the message */
int lay_out(problem_file *problem, budget *limit, laid_out *made);
int lay_out_problem(const char *name, const qs_problem *problem, const char *mend, budget *limit,
                    laid_out *made);

/* The same without a model, for a solver that takes the problem itself. The problem is a grid
 * without masked cells. */
int lay_out_straight(const char *name, const qs_problem *problem, laid_out *made);

/* The beginning of advice where costs overflow: costs are whole numbers of 1 / scale, and the scale
 * comes from the decimals of --lambda. "" if `mend` does not name it, or if it has none. */
const char *fewer_decimals(const char *mend, uint32_t scale);

/* What a solver found. */
typedef struct solved {
    const char *solver;
    qs_status refusal; /* QS_OK, or why the solver cannot be used; then nothing else is set */
    qs_solution solution;
    int64_t microseconds; /* of the solver alone */
    bool out_of_time; /* the time limit stopped it */
    bool in_gap; /* the gap limit did */
    bool interrupted; /* a signal did */
    bool own_limit; /* no limit of iterations was asked for */
    uint16_t *labelling; /* of the problem's sites; the budget owns it */
    uint8_t *bits; /* the sample of it, if the problem is a file; the budget owns it */
    int64_t qubo_energy; /* H of the sample: less than the solution's energy if the costs were
                            truncated */
} solved;

/* The bytes that solve_problem takes.
 *
 * iterations  as in a search */
uint64_t solve_bytes(const laid_out *problem, const solver *by, uint64_t iterations);

/* Solves the problem, from the start if there is one. The energy is computed again, from the sample
 * or the problem. What was found stays in memory of the budget, the work does not. Returns DONE,
 * also if the solver refuses, or
 * NO_RESOURCE. */
int solve_problem(const laid_out *problem, const solver *by, const search *how, budget *limit,
                  solved *found);

/* Prints why the solver cannot be used, and which can. Returns DONE if it can, else BAD_USAGE. */
int solved_check(const laid_out *problem, const solver *by, const solved *found);

bool solved_has_bound(const solved *found);
bool solved_is_proven(const solved *found);

/* Print how good the energy is and what it took: keys of JSON, and lines for people. */
void solved_json(const solved *found, uint32_t scale);
void solved_print(const solved *found, uint32_t scale);

#endif
