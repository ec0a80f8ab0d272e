#include "labels_of_problem.h"

#include "../problem/edge_runs.h"

static bool is_truncated(qs_smoothness smoothness)
{
    return smoothness == QS_TRUNCATED_LINEAR || smoothness == QS_TRUNCATED_QUADRATIC;
}

qs_pairwise qs_pairwise_of(const qs_problem *problem)
{
    const qs_pairwise *given = &problem->pairwise;
    qs_pairwise pairwise = {.smoothness = given->smoothness};
    if (is_truncated(given->smoothness)) {
        pairwise.truncation = given->truncation;
    }
    if (given->smoothness == QS_TABLE) {
        pairwise.table = given->table;
    }
    return pairwise;
}

/* The weight of every edge seen so far; none yet, or they differ. */
typedef struct common_weight {
    const qs_problem *problem;
    int32_t weight;
    bool any, differ;
} common_weight;

static void compare_weights(void *context, const qs_edge_run *run)
{
    common_weight *common = context;
    for (uint32_t r = 0; r < run->repeat && !common->differ; r++) {
        for (uint32_t c = 0; c < run->count && !common->differ; c++) {
            int32_t weight = qs_edge_weight(common->problem, run, r, c);
            common->differ = common->any && weight != common->weight;
            common->any = true;
            common->weight = weight;
        }
    }
}

/* The weight of every edge, -1 where they differ; 0 of no edges. */
static int32_t weight_of(const qs_problem *problem)
{
    common_weight common = {.problem = problem};
    if (problem->grid.width > 0 && !problem->grid.right) {
        return problem->weight; /* even where there is no edge */
    }
    qs_edges_visit(problem, compare_weights, &common);
    return common.differ ? -1 : common.weight;
}

qs_labels qs_labels_with_mask(const qs_problem *problem, const uint8_t *mask)
{
    qs_labels labels = {.encoding = QS_ONE_HOT,
                        .pairwise = qs_pairwise_of(problem),
                        .labels = problem->labels,
                        .scale = problem->scale,
                        .gap = 1,
                        .weight = weight_of(problem),
                        .width = problem->grid.width,
                        .height = problem->grid.height,
                        .frame = problem->frame,
                        .meaning = problem->meaning,
                        .mask = mask,
                        .sites = qs_problem_sites(problem)};
    labels.pairwise.table = NULL;
    labels.undecided = labels.sites;
    if (labels.frame.picture_width == 0) {
        labels.frame.picture_width = labels.width;
        labels.frame.picture_height = labels.height;
    }
    return labels;
}

qs_status qs_labels_of_problem(const qs_problem *problem, qs_labels *labels)
{
    qs_status status = qs_problem_check(problem);
    if (status == QS_OK && (!labels || problem->grid.mask)) {
        status = QS_E_ARGUMENT;
    }
    if (status == QS_OK) {
        *labels = qs_labels_with_mask(problem, NULL);
    }
    return status;
}
