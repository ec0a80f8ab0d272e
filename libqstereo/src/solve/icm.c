#include "../../include/qstereo/solve.h"

#include "../model/neighbours.h"
#include "progress.h"

size_t qs_icm_workspace(const qs_model *model)
{
    (void)model;
    return 0;
}

/* One sweep. Returns how many sites change.
 *
 * gain  out: by how much the energy falls */
static uint32_t sweep(const qs_model *model, uint16_t *labelling, int64_t *gain)
{
    uint32_t changed = 0;
    *gain = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        uint16_t best = qs_best_label(model, labelling, p);
        if (best != labelling[p]) {
            *gain += qs_label_cost(model, labelling, p, labelling[p]) -
                     qs_label_cost(model, labelling, p, best);
            labelling[p] = best;
            changed++;
        }
    }
    return changed;
}

qs_status qs_icm(const qs_model *model, const qs_solve_options *options, void *workspace,
                 size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    (void)workspace;
    (void)workspace_size;
    if (!model || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    qs_solution s = {.energy = qs_model_energy(model, labelling), .lower_bound = QS_NO_BOUND};
    bool go = true;
    while (go && !s.converged) {
        int64_t gain;
        uint32_t changed = sweep(model, labelling, &gain);
        s.converged = changed == 0; /* of equals the lower label is taken, so this ends */
        s.energy -= gain;
        s.iterations++;
        go = qs_report_progress(options, &s) && !qs_limit_reached(options, &s, 0);
    }
    s.energy -= qs_take_kept_everywhere(model, labelling);
    *solution = s;
    return QS_OK;
}
