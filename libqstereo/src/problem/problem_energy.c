#include "../../include/qstereo/problem.h"

#include <stdbool.h>

#include "cost_strips.h"
#include "edge_runs.h"
#include "edge_tables.h"
#include "pairwise.h"

/* Hands out the workspace, or counts it.
 *
 * costs  out: of the strips of costs */
static size_t take_parts(const qs_problem *problem, void *workspace, void **costs,
                         qs_table_strip *tables)
{
    qs_arena arena = {.base = workspace};
    *costs = qs_arena_take(&arena, problem->costs ? 0 : qs_costs_workspace(problem), 1);
    if (problem->pairwise.smoothness == QS_TABLES) {
        *tables = qs_table_strip_first(problem, &arena);
    }
    return qs_arena_size(&arena);
}

size_t qs_problem_workspace(const qs_problem *problem)
{
    void *costs;
    qs_table_strip tables;
    return take_parts(problem, NULL, &costs, &tables);
}

/* A sum that stays within +- QS_ENERGY_MAX. */
typedef struct total {
    const qs_problem *problem;
    const uint16_t *labelling;
    int64_t energy;
    bool overflow;
    bool bad_table; /* an entry is below 0 */
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

/* The same without the costs of the other labels. */
static void add_picked_costs(total *sum, int32_t *costs)
{
    const qs_problem *problem = sum->problem;
    const qs_cost_source *source = &problem->source;
    uint32_t width = problem->grid.width;
    for (uint32_t y = 0; y < problem->grid.height; y++) {
        source->pick(source->context, y, sum->labelling + (size_t)y * width, costs);
        for (uint32_t x = 0; x < width; x++) {
            add(sum, 1, costs[x]);
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

static void add_tables(total *sum, qs_table_strip *strip)
{
    uint32_t labels = sum->problem->labels;
    while (qs_table_strip_next(strip)) {
        for (uint32_t at = 0; at < strip->count; at++) {
            qs_table_edge edge = qs_table_edge_at(strip, at);
            if (edge.weight != 0) {
                uint16_t a = sum->labelling[edge.first], b = sum->labelling[edge.second];
                int32_t cost = edge.table[(size_t)a * labels + b];
                sum->bad_table |= cost < 0;
                add(sum, edge.weight, cost);
            }
        }
    }
}

/* Returns true if each site has a label that there is and that is allowed. */
static bool is_labelling(const qs_problem *problem, const uint16_t *labelling)
{
    const uint8_t *allowed = problem->allowed;
    size_t labels = problem->labels;
    for (uint32_t p = 0, sites = qs_problem_sites(problem); p < sites; p++) {
        if (labelling[p] >= labels || (allowed && allowed[p * labels + labelling[p]] == 0)) {
            return false;
        }
    }
    return true;
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
    void *costs;
    qs_table_strip tables;
    if (workspace_size < take_parts(problem, workspace, &costs, &tables)) {
        return QS_E_WORKSPACE;
    }
    if (!is_labelling(problem, labelling)) {
        return QS_E_ARGUMENT;
    }
    total sum = {.problem = problem, .labelling = labelling};
    if (problem->costs) {
        add_costs(&sum);
    } else if (problem->source.pick && !problem->grid.mask) {
        add_picked_costs(&sum, costs);
    } else {
        add_made_costs(&sum, costs);
    }
    if (problem->pairwise.smoothness == QS_TABLES) {
        add_tables(&sum, &tables);
    } else {
        qs_edges_visit(problem, add_edges, &sum);
    }
    if (sum.bad_table) {
        return QS_E_ARGUMENT;
    }
    if (sum.overflow) {
        return QS_E_OVERFLOW;
    }
    *energy = sum.energy;
    return QS_OK;
}
