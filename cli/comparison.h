/* The answers of several solvers to one problem, side by side. */
#ifndef COMPARISON_H
#define COMPARISON_H

#include "pictures/map_errors.h"
#include "output.h"
#include "qstereo.h"

/* Each result may have a map, and all have one trace. */
enum { RESULTS_MAX = OUTPUTS_MAX - 1 };

typedef struct result {
    char solver[256]; /* the longest name of a .qsf, and its end */
    const char *file; /* the samples file that has it; NULL = it was solved here */
    qs_status refusal; /* QS_OK, or why the solver cannot be used */
    uint32_t feasible, samples;
    int64_t energy; /* of the best feasible sample, if there is one */
    int64_t lower_bound; /* QS_NO_BOUND if the solver gives none */
    int64_t microseconds; /* negative = not known */
    map_errors errors; /* without pixels if there is no truth or no feasible sample */
    char *map; /* name for the file; NULL = none is asked for. The budget owns it */
    bool has_map; /* it has been written */
} result;

typedef struct comparison {
    uint32_t scale;
    bool scored; /* there is a truth */
    const char *trace; /* the file with the courses of the solvers; NULL = none */
    result results[RESULTS_MAX];
    size_t count;
} comparison;

/* Adds a result that is all zero but for its name, bound and seconds. Returns DONE, or BAD_USAGE,
 * after a message, if there are RESULTS_MAX already. */
int comparison_add(comparison *to, const char *solver, size_t solver_size, result **added);

/* Print the results as JSON, and as a table for people. */
void comparison_json(const comparison *shown);
void comparison_print(const comparison *shown);

#endif
