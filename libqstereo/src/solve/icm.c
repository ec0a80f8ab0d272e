#include "../../include/qstereo/solve.h"

#include "../model/neighbours.h"
#include "progress.h"

size_t qs_icm_workspace(const qs_model *model)
{
    (void)model;
    return 0;
}

/* One sweep. Returns how many sites change. */
static uint32_t sweep(const qs_model *model, qs_look *look, uint16_t *labelling, qs_solution *s)
{
    uint32_t changed = 0;
    for (uint32_t p = 0; p < model->sites && qs_look_up(look, qs_work_at(model, p)); p++) {
        uint16_t best = qs_best_label(model, labelling, p);
        if (best != labelling[p]) {
            s->energy += qs_label_cost(model, labelling, p, best) -
                         qs_label_cost(model, labelling, p, labelling[p]);
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
    qs_reporter reporter = {options, &s};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    bool go = true;
    while (go && !s.converged) {
        uint32_t changed = sweep(model, &look, labelling, &s);
        if (look.stopped) {
            break;
        }
        s.converged = changed == 0; /* of equals the lower label is taken, so this ends */
        s.iterations++;
        go = qs_report_progress(options, &s) && !qs_limit_reached(options, &s, 0);
    }
    s.energy -= qs_take_kept_everywhere(model, labelling);
    *solution = s;
    return QS_OK;
}
