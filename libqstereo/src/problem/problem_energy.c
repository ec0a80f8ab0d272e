#include "../../include/qstereo/problem.h"

#include <stdbool.h>

#include "cost_strips.h"
#include "edge_runs.h"
#include "pairwise.h"

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
