/* What all solvers do after an iteration: tell the watch, look at the limit. */
#ifndef QS_PROGRESS_H
#define QS_PROGRESS_H

#include "../../include/qstereo/solve.h"

/* Tells the watch, if there is one; false = stop. */
static inline bool qs_told(const qs_solve_options *options, const qs_solution *s)
{
    qs_progress progress = {s->energy, s->lower_bound, s->iterations};
    return !options || !options->watch || options->watch(options->context, &progress);
}

/* Whether the iterations asked for, or the solver's own default (0 = none), are done. */
static inline bool qs_limit_reached(const qs_solve_options *options, const qs_solution *s,
                                    uint64_t standard)
{
    uint64_t limit = options && options->iterations > 0 ? options->iterations : standard;
    return limit > 0 && s->iterations >= limit;
}

#endif
