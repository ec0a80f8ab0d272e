/* The commands that make a problem, solve it and write what was found in one go: what they
 * share. */
#ifndef ONE_GO_H
#define ONE_GO_H

#include "command.h"
#include "made.h"
#include "meanings.h"

/* The options that each of them has come first, then those of its maker. */
enum {
    ONE_GO_OUTPUT,
    ONE_GO_SOLVER,
    ONE_GO_SEARCH,
    ONE_GO_TRUTH = ONE_GO_SEARCH + SEARCH_OPTIONS,
    ONE_GO_JSON,
    ONE_GO_MEMORY_LIMIT,
    ONE_GO_MAKER
};
#define ONE_GO_OPTION_ROWS(truth)                                                                  \
    [ONE_GO_SOLVER] = SOLVER_OPTION, [ONE_GO_SEARCH] = SEARCH_OPTION_ROWS,                         \
    [ONE_GO_TRUTH] = {"truth", 0, false, "TRUTH", NULL, truth}, [ONE_GO_JSON] = JSON_OPTION,       \
    [ONE_GO_MEMORY_LIMIT] = MEMORY_LIMIT_OPTION

typedef struct one_go {
    const solver *by;
    search how;
    const char *truth; /* NULL = nothing is scored */
    made_problem made;
    laid_out laid;
    solved found;
} one_go;

/* Reads the arguments of the shared rows. Returns DONE or BAD_USAGE. */
int one_go_read(const job *at, one_go *run);

/* Makes the problem; one_go_solve solves it. Return DONE, BAD_INPUT or NO_RESOURCE. */
int one_go_open(job *at, const maker *by, void *state, one_go *run);
int one_go_solve(job *at, one_go *run);

/* Begins to print the result: keys of JSON, or lines for people. Returns false if standard output
 * is the output, so that nothing may be printed. Else the score is to follow, and one_go_end. */
bool one_go_print(const job *at, const one_go *run);
void one_go_end(const job *at);

#endif
