/* The answers of several solvers to one problem, side by side. */
#ifndef COMPARISON_H
#define COMPARISON_H

#include "map_errors.h"
#include "output.h"
#include "qstereo.h"

/* Each may have a map. */
enum { RESULTS_MAX = OUTPUTS_MAX };

typedef struct result {
    char solver[256]; /* the longest name of a .qsf, and its end */
    qs_status refusal; /* QS_OK, or why the solver cannot be used */
    uint32_t feasible, samples;
    int64_t energy; /* of the best feasible sample, if there is one */
    int64_t lower_bound; /* QS_NO_BOUND where the solver has none */
    int64_t microseconds; /* negative = not known */
    map_errors errors; /* without pixels where there is no truth or no feasible sample */
    char *map; /* name for the file; NULL = none is asked for. To be freed */
    bool has_map; /* it has been written */
} result;

typedef struct comparison {
    uint32_t scale;
    bool scored; /* there is a truth */
    result results[RESULTS_MAX];
    size_t count;
} comparison;

/* The next result, all zero but for its name, bound and seconds. Returns DONE, or BAD_USAGE where
 * there are RESULTS_MAX. */
int comparison_add(comparison *to, const char *solver, size_t solver_size, result **added);
void comparison_free(comparison *freed);

/* As JSON, and as a table for people. */
void comparison_json(const comparison *shown);
void comparison_print(const comparison *shown);

#endif
