#include "cut_descent.h"

#include "../model/neighbours.h"
#include "fusion.h"
#include "progress.h"

size_t qs_descent_workspace(const qs_model *model)
{
    return qs_fusion_moves_workspace(model);
}

/* Steps up and down in turn, until both have failed: the labelling is optimal for steps of 1. */
static bool descend(qs_fusion *f, int32_t step)
{
    qs_solution *solution = f->solution;
    int failed = 0;
    for (int32_t way = 1; failed < 2; way = -way) {
        int64_t gain;
        qs_propose_jump(f, way * step);
        if (!qs_fuse(f, &gain)) {
            return false;
        }
        failed = gain > 0 ? 0 : failed + 1;
        bool proven = step == 1 && failed == 2;
        solution->iterations++;
        solution->energy = f->m.energy;
        solution->lower_bound = proven ? solution->energy : QS_NO_BOUND;
        bool more =
            qs_report_progress(f->options, solution) && !qs_limit_reached(f->options, solution, 0);
        if (!more && !proven) {
            return false;
        }
    }
    return true;
}

qs_status qs_descent(const qs_model *model, const qs_solve_options *options, void *workspace,
                     uint16_t *labelling, qs_solution *solution)
{
    qs_arena arena = {.base = workspace};
    qs_fusion f = {.m = {.model = model, .x = labelling}, .options = options, .solution = solution};
    (void)qs_take_kept_everywhere(model, labelling);
    qs_fusion_take(&f, &arena);
    qs_fusion_start(&f);
    *solution = (qs_solution){.energy = f.m.energy, .lower_bound = QS_NO_BOUND};
    int32_t step = 1;
    while (2 * step < (int32_t)model->labels) {
        step *= 2;
    }
    while (step > 0 && descend(&f, step)) {
        step /= 2;
    }
    solution->converged = step == 0;
    return QS_OK;
}
