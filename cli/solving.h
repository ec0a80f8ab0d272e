/* The solvers by their names, how long they may search, and what they find. */
#ifndef SOLVING_H
#define SOLVING_H

#include <stddef.h>
#include <stdint.h>

#include "inputs.h"
#include "qstereo.h"
#include "text/names.h"

/* How long a solver may search: the options of every command that solves. */

/* Rows for a table of options, one behind the other. */
enum { SEARCH_TIME_LIMIT, SEARCH_ITERATIONS, SEARCH_SEED, SEARCH_OPTIONS };
#define SEARCH_OPTION_ROWS                                                                         \
    {"time-limit", 0,                                                                              \
     false,        "S",                                                                            \
     NULL,         "stop a solver after S seconds and take its best so far (default no limit)"},   \
        {"iterations", 0,    false,                                                                \
         "N",          NULL, "stop a solver after N iterations (default its own limit)"},          \
        {"seed", 0,   false,                                                                       \
         "N",    "0", "of the random numbers of anneal; the same seed gives the same answer"}

typedef struct search {
    int64_t time_limit; /* microseconds; 0 = none */
    uint64_t iterations; /* 0 = the solver's own limit */
    uint64_t seed;
} search;

/* Reads the arguments of the rows. Returns DONE or BAD_USAGE. */
int search_read(const char *const *values, search *asked);

/* The library's solvers by their names. */

typedef struct solver {
    const char *name;
    qs_solver *run;
    size_t (*workspace)(const qs_model *model);
} solver;

enum { SOLVERS = 7 };

/* In the order in which they are compared. */
extern const solver solvers[SOLVERS];

/* A row for a table of options. */
#define SOLVER_OPTION                                                                              \
    {"solver", 0, false, "NAME", "best", "icm, anneal, swap, expansion, bp, trws or best"}

/* The argument of --solver. Returns DONE, or BAD_USAGE having listed the known ones. */
int solver_read(const char *text, const solver **chosen);

/* One name, `length` letters of `text`, of the argument of --solvers. */
int solvers_read(const char *text, size_t length, const solver **chosen);

/* Solving the problem of a .qcf with the library's solvers. */

/* A problem laid out for the solvers. */
typedef struct laid_out {
    const problem_file *problem;
    qs_model model;
    void *workspace;
} laid_out;

/* Indexes an open problem and lays it out. Returns DONE, BAD_INPUT or NO_RESOURCE, having said why;
 * laid_out_close frees what was allocated in any case. */
int laid_out_open(problem_file *problem, budget *limit, laid_out *opened);
void laid_out_close(laid_out *closed);

/* What a solver found. */
typedef struct solved {
    const char *solver;
    qs_status refusal; /* QS_OK, or why the solver cannot be used; then nothing else is set */
    qs_solution solution;
    int64_t microseconds; /* of the solver alone */
    bool out_of_time; /* the time limit stopped it */
    bool own_limit; /* no limit of iterations was asked for */
    uint16_t *labelling; /* of the problem's sites; to be freed */
    uint8_t *bits; /* the sample of it; to be freed */
    int64_t qubo_energy; /* H of the sample: less than the solution's energy where the costs were
                            truncated */
} solved;

/* Solves; the energy has been recomputed from the sample. The limit is for the solver's work and
 * what it found. Returns DONE, also where the solver refuses, or NO_RESOURCE, having said why. */
int solve_problem(const laid_out *problem, const solver *by, const search *how, budget limit,
                  solved *found);
void solved_free(solved *freed);

/* Says why the solver cannot be used. Returns DONE where it can, else BAD_INPUT. */
int solved_check(const laid_out *problem, const solved *found);

bool solved_has_bound(const solved *found);
bool solved_is_proven(const solved *found);

/* The keys of JSON, and lines for people: how good the energy is, and what it took. */
void solved_json(const solved *found, uint32_t scale);
void solved_print(const solved *found, uint32_t scale);

#endif
