/* What every solver does after an iteration: report, and look at its limit. */
#ifndef QS_PROGRESS_H
#define QS_PROGRESS_H

#include "../../include/qstereo/solve.h"

/* Reports to the watch, if there is one. Returns false if the solver is to stop. */
static inline bool qs_report_progress(const qs_solve_options *options, const qs_solution *s)
{
    qs_progress progress = {s->energy, s->lower_bound, s->iterations};
    return !options || !options->watch || options->watch(options->context, &progress);
}

/* Returns true if all iterations are done: as many as asked for, or as the solver does by itself.
 *
 * standard  the solver's own limit; 0 = none */
static inline bool qs_limit_reached(const qs_solve_options *options, const qs_solution *s,
                                    uint64_t standard)
{
    uint64_t limit = options && options->iterations > 0 ? options->iterations : standard;
    return limit > 0 && s->iterations >= limit;
}

#endif
