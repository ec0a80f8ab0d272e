#include "../../include/qstereo/problem.h"

#include <stdbool.h>

#include "cost_strips.h"
#include "edge_runs.h"
#include "pairwise.h"

static bool weights_in_range(const int32_t *weights, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (weights[i] < 0) {
            return false;
        }
    }
    return true;
}

static qs_status check_pairwise(const qs_problem *problem)
{
    const qs_pairwise *pairwise = &problem->pairwise;
    if (pairwise->smoothness != QS_TABLE) {
        return pairwise->smoothness <= QS_TABLE ? QS_OK : QS_E_ARGUMENT;
    }
    size_t labels = problem->labels;
    return pairwise->table && weights_in_range(pairwise->table, labels * labels) ? QS_OK
                                                                                 : QS_E_ARGUMENT;
}

static qs_status check_grid(const qs_problem *problem)
{
    const qs_grid *grid = &problem->grid;
    uint64_t cells = (uint64_t)grid->width * grid->height;
    if (grid->height == 0 || problem->weight < 0 || problem->edges || !grid->right != !grid->down) {
        return QS_E_ARGUMENT;
    }
    if (cells > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    if (grid->right && (!weights_in_range(grid->right, (size_t)cells) ||
                        !weights_in_range(grid->down, (size_t)cells))) {
        return QS_E_ARGUMENT;
    }
    const qs_frame *frame = &problem->frame;
    bool framed = frame->picture_width > 0;
    if (framed ? frame->x > frame->picture_width || grid->width > frame->picture_width - frame->x ||
                     frame->y > frame->picture_height ||
                     grid->height > frame->picture_height - frame->y
               : frame->picture_height > 0 || frame->x > 0 || frame->y > 0) {
        return QS_E_ARGUMENT;
    }
    return QS_OK;
}

static qs_status check_edges(const qs_problem *problem)
{
    const qs_frame *frame = &problem->frame;
    bool framed = frame->picture_width > 0 || frame->picture_height > 0 || frame->x > 0 ||
                  frame->y > 0;
    if ((problem->edge_count > 0 && !problem->edges) || framed) {
        return QS_E_ARGUMENT;
    }
    if (problem->edge_count > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    for (size_t e = 0; e < problem->edge_count; e++) {
        const qs_edge *edge = &problem->edges[e];
        if (edge->first >= edge->second || edge->second >= problem->sites || edge->weight < 0) {
            return QS_E_ARGUMENT;
        }
    }
    return QS_OK;
}

static bool has_costs(const qs_problem *problem)
{
    const qs_cost_source *source = &problem->source;
    return problem->costs ||
           (source->row && problem->grid.width > 0 && (source->bytes == 1 || source->bytes == 4));
}

qs_status qs_problem_check(const qs_problem *problem)
{
    if (!problem || problem->labels < 1 || problem->labels > QS_LABELS_MAX || problem->scale < 1 ||
        !has_costs(problem) || problem->frame.first > INT32_MAX) {
        return QS_E_ARGUMENT;
    }
    qs_status status = problem->grid.width > 0 ? check_grid(problem) : check_edges(problem);
    if (status != QS_OK) {
        return status;
    }
    uint32_t sites = qs_problem_sites(problem);
    if (sites == 0) {
        return QS_E_ARGUMENT;
    }
    if ((uint64_t)sites * problem->labels > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    return check_pairwise(problem);
}

uint32_t qs_problem_sites(const qs_problem *problem)
{
    const qs_grid *grid = &problem->grid;
    if (grid->width == 0) {
        return problem->sites;
    }
    uint32_t cells = grid->width * grid->height, sites = cells;
    for (uint32_t i = 0; grid->mask && i < cells; i++) {
        sites -= grid->mask[i] == 0;
    }
    return sites;
}

int64_t qs_pairwise_cost(const qs_problem *problem, uint32_t a, uint32_t b)
{
    return qs_pairwise_value(&problem->pairwise, problem->labels, a, b);
}

size_t qs_problem_workspace(const qs_problem *problem)
{
    return problem->costs ? 0 : qs_costs_workspace(problem);
}

/* A sum that stays within +- QS_ENERGY_MAX. */
typedef struct total {
    const qs_problem *problem;
    const uint16_t *labelling;
    int64_t energy;
    bool overflow;
} total;

static void add(total *sum, int64_t weight, int64_t cost)
{
    if (sum->overflow || (cost > 0 && weight > QS_ENERGY_MAX / cost)) {
        sum->overflow = true;
        return;
    }
    sum->energy += weight * cost;
    sum->overflow = sum->energy > QS_ENERGY_MAX || sum->energy < -QS_ENERGY_MAX;
}

static void add_costs(total *sum)
{
    const qs_problem *problem = sum->problem;
    for (uint32_t p = 0, sites = qs_problem_sites(problem); p < sites; p++) {
        add(sum, 1, problem->costs[(size_t)p * problem->labels + sum->labelling[p]]);
    }
}

static void add_made_costs(total *sum, void *workspace)
{
    const uint16_t *label = sum->labelling;
    for (qs_strip strip = qs_strip_first(sum->problem, workspace); qs_strip_next(&strip);) {
        add(sum, 1, strip.least_sum);
        for (uint32_t i = 0; i < strip.sites; i++) {
            add(sum, 1, qs_strip_cost(&strip, (size_t)i * sum->problem->labels + *label++));
        }
    }
}

static void add_edges(void *context, const qs_edge_run *run)
{
    total *sum = context;
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            uint32_t p = run->list ? run->list[c].first : run->first + r * run->stride + c;
            uint32_t q = run->list ? run->list[c].second : run->second + r * run->stride + c;
            int64_t cost = qs_pairwise_cost(sum->problem, sum->labelling[p], sum->labelling[q]);
            add(sum, qs_edge_weight(sum->problem, run, r, c), cost);
        }
    }
}

qs_status qs_problem_energy(const qs_problem *problem, const uint16_t *labelling, void *workspace,
                            size_t workspace_size, int64_t *energy)
{
    qs_status status = qs_problem_check(problem);
    if (status != QS_OK) {
        return status;
    }
    if (!labelling || !energy || (!workspace && qs_problem_workspace(problem) > 0)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_problem_workspace(problem)) {
        return QS_E_WORKSPACE;
    }
    for (uint32_t p = 0, sites = qs_problem_sites(problem); p < sites; p++) {
        if (labelling[p] >= problem->labels) {
            return QS_E_ARGUMENT;
        }
    }
    total sum = {problem, labelling, 0, false};
    if (problem->costs) {
        add_costs(&sum);
    } else {
        add_made_costs(&sum, workspace);
    }
    qs_edges_visit(problem, add_edges, &sum);
    if (sum.overflow) {
        return QS_E_OVERFLOW;
    }
    *energy = sum.energy;
    return QS_OK;
}
