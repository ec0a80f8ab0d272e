/* What every solver does: after an iteration it reports and looks at its limit, and within one it
 * looks at the watch now and then. */
#ifndef QS_PROGRESS_H
#define QS_PROGRESS_H

#include <string.h>

#include "../../include/qstereo/solve.h"

/* Reports to the watch, if there is one. Returns false if the solver is to stop. */
static inline bool qs_report_progress(const qs_solve_options *options, const qs_solution *s)
{
    qs_progress progress = {s->energy, s->lower_bound, s->iterations};
    return !options || !options->watch || options->watch(options->context, &progress);
}

/* A look at the watch within an iteration. */
typedef struct qs_look {
    bool (*going)(void *context); /* asks the watch; returns false to stop */
    void *context;
    uint64_t done; /* work since the last look */
    bool stopped;
} qs_look;

enum { QS_BETWEEN_LOOKS = 1 << 20 }; /* numbers computed: about a millisecond's work */

/* Counts work, and looks if it is time. Returns false if the solver is to stop; from then on it
 * always does.
 *
 * look  NULL = nobody looks
 * work  numbers computed since the last call */
static inline bool qs_look_up(qs_look *look, uint64_t work)
{
    if (!look || look->stopped) {
        return !look;
    }
    look->done += work;
    if (look->done >= QS_BETWEEN_LOOKS) {
        look->done = 0;
        look->stopped = !look->going(look->context);
    }
    return !look->stopped;
}

/* Work that may still be done. The watch ends it sooner. */
typedef struct qs_allowance {
    uint64_t left; /* numbers that may be looked at */
    qs_look *look;
} qs_allowance;

/* Returns false if the watch stops it; then nothing is left. */
static inline bool qs_spend(qs_allowance *work, uint64_t numbers)
{
    bool go = qs_look_up(work->look, numbers);
    work->left = go && numbers < work->left ? work->left - numbers : 0;
    return go;
}

/* Takes off what a part of it, of `share` numbers and with the same look, has used. */
static inline void qs_take_used(qs_allowance *work, uint64_t share, const qs_allowance *part)
{
    uint64_t used = share - part->left;
    bool stopped = work->look && work->look->stopped;
    work->left = !stopped && used < work->left ? work->left - used : 0;
}

enum { QS_SITES_TOGETHER = 256 }; /* a power of two: sites between two calls of qs_look_up */

/* The same in a loop over sites; `at` counts them.
 *
 * each  numbers computed for each site */
static inline bool qs_look_at(qs_look *look, uint32_t at, uint64_t each)
{
    return at % QS_SITES_TOGETHER != 0 || qs_look_up(look, QS_SITES_TOGETHER * each);
}

/* Fills memory with 0. Large memory takes time, too. Returns false if the watch stops it. */
static inline bool qs_clear(qs_look *look, void *memory, size_t size)
{
    enum { TOGETHER = 1 << 22 };
    char *at = memory;
    bool go = true;
    for (size_t left = size; left > 0 && go;) {
        size_t part = left < TOGETHER ? left : TOGETHER;
        memset(at, 0, part);
        at += part;
        left -= part;
        go = qs_look_up(look, part / sizeof(int32_t));
    }
    return go;
}

/* For solvers that report what they have when they look. */
typedef struct qs_reporter {
    const qs_solve_options *options;
    const qs_solution *solution;
} qs_reporter;

static inline bool qs_report_now(void *reporter)
{
    const qs_reporter *r = reporter;
    return qs_report_progress(r->options, r->solution);
}

/* The labelling is proven to be optimal. */
static inline bool qs_is_proven(const qs_solution *s)
{
    return s->energy <= s->lower_bound;
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
