#include "cut.h"

#include "../model/convexity.h"
#include "../model/neighbours.h"
#include "cut_descent.h"
#include "cut_levels.h"
#include "fusion.h"
#include "solve_64.h"

/* Descent has a node for each site, levels one for each site and label. With two labels these are
 * the same, and levels need one cut. */
static bool descends(const qs_model *model)
{
    return model->labels > 2 && qs_pairwise_is_convex(model) && qs_unary_is_convex(model);
}

static bool fits(const qs_model *model)
{
    return descends(model) ? qs_fusion_fits(model) : qs_levels_fit(model);
}

bool qs_cut_is_quick(const qs_model *model)
{
    return qs_pairwise_is_submodular(model) &&
           (model->labels <= 2 || qs_levels_send(model) || descends(model));
}

size_t qs_min_cut_workspace(const qs_model *model)
{
    if (!qs_pairwise_is_submodular(model)) {
        return 0;
    }
    if (!fits(model)) {
        return QS_IN_64_BITS(SIZE_MAX, qs_min_cut_workspace, model);
    }
    return descends(model) ? qs_descent_workspace(model) : qs_levels_workspace(model);
}

qs_status qs_min_cut(const qs_model *model, const qs_solve_options *options, void *workspace,
                     size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (!qs_pairwise_is_submodular(model)) {
        return QS_E_ENCODING;
    }
    if (!fits(model)) {
        return QS_IN_64_BITS(QS_E_OVERFLOW, qs_min_cut, model, options, workspace, workspace_size,
                             labelling, solution);
    }
    size_t needed = qs_min_cut_workspace(model);
    if (needed == SIZE_MAX || workspace_size < needed || !workspace) {
        return QS_E_WORKSPACE;
    }
    return descends(model) ? qs_descent(model, options, workspace, labelling, solution)
                           : qs_levels(model, options, workspace, labelling, solution);
}
