/* Solvers that take a problem itself, not a model: which problems they take. */
#ifndef QS_STRAIGHT_H
#define QS_STRAIGHT_H

#include "../../include/qstereo/solve.h"

/* Grids without masked cells and forbidden labels, with Potts or truncated linear costs. */
static inline bool qs_straight_takes(const qs_problem *problem)
{
    qs_smoothness smoothness = problem->pairwise.smoothness;
    return problem->grid.width > 0 && !problem->grid.mask && !problem->allowed &&
           (smoothness == QS_POTTS || smoothness == QS_TRUNCATED_LINEAR);
}

/* Checks what such a solver was given, but for the size of its workspace. */
static inline qs_status qs_straight_check(const qs_problem *problem, const void *workspace,
                                          const uint16_t *labelling, const qs_solution *solution)
{
    if (!problem || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    qs_status status = qs_problem_check(problem);
    return status != QS_OK || qs_straight_takes(problem) ? status : QS_E_ENCODING;
}

/* Labels further apart than this cost no more. Without truncation it is the largest distance that
 * there can be. */
static inline uint32_t qs_straight_reach(const qs_problem *problem)
{
    uint32_t most = problem->labels > 1 ? problem->labels - 1 : 1;
    uint32_t cut = problem->pairwise.truncation;
    if (problem->pairwise.smoothness == QS_POTTS) {
        return 1;
    }
    return cut > 0 && cut < most ? cut : most;
}

#endif
