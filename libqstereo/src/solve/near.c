/* A labelling made better by labels near its own: lines of the grid, one after the other, each
 * solved exactly beside the labels of the lines next to it. */
#include <string.h>

#include "../../include/qstereo/solve.h"
#include "../base/arena.h"
#include "../base/minmax.h"
#include "progress.h"

enum { NEAR = 3, DEFAULT_ITERATIONS = 1 };

typedef struct state {
    const qs_problem *problem;
    uint32_t width, height, labels;
    uint32_t reach; /* labels further apart cost no more */
    uint16_t *labelling;
    uint16_t *middle; /* of each site: its labels are middle - 1, middle and middle + 1 */
    int32_t *costs[NEAR]; /* of these */
    uint8_t *from; /* of a line's sites: the label of the one before that each label goes with */
    qs_look *look;
} state;

/* Sites from `first`, `stride` apart, with the edges to the next one and to the lines beside. */
typedef struct line {
    size_t first, stride, count;
    const int32_t *ahead, *aside; /* weights; NULL = the problem's */
    size_t across; /* from a line to the next one */
    bool has_before, has_after; /* there is a line on this side */
} line;

static size_t take_parts(state *s, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t sites = (uint64_t)s->width * s->height;
    for (int i = 0; i < NEAR; i++) {
        s->costs[i] = qs_arena_take(&arena, sites, sizeof *s->costs[i]);
    }
    s->middle = qs_arena_take(&arena, sites, sizeof *s->middle);
    s->from = qs_arena_take(&arena, qs_max_u32(s->width, s->height), NEAR);
    return qs_arena_size(&arena);
}

static bool is_for_us(const qs_problem *problem)
{
    const qs_pairwise *v = &problem->pairwise;
    return problem->source.pick && !problem->costs && problem->grid.width > 0 &&
           !problem->grid.mask && !problem->allowed &&
           (v->smoothness == QS_POTTS || v->smoothness == QS_TRUNCATED_LINEAR);
}

static state state_of(const qs_problem *problem)
{
    uint32_t cut = problem->pairwise.truncation;
    bool potts = problem->pairwise.smoothness == QS_POTTS;
    return (state){.problem = problem,
                   .width = problem->grid.width,
                   .height = problem->grid.height,
                   .labels = problem->labels,
                   .reach = potts     ? 1
                            : cut > 0 ? cut
                                      : QS_LABELS_MAX};
}

size_t qs_near_workspace(const qs_problem *problem)
{
    if (!is_for_us(problem)) {
        return 0;
    }
    state counted = state_of(problem);
    return take_parts(&counted, NULL);
}

static int64_t between(const state *s, int64_t weight, uint32_t a, uint32_t b)
{
    return weight * qs_min_u32(a > b ? a - b : b - a, s->reach);
}

static int64_t weight_at(const state *s, const int32_t *weights, size_t site)
{
    return weights ? weights[site] : s->problem->weight;
}

/* Label i of a site, of NEAR. The first and the last one of the problem have a neighbour less: that
 * is the label itself. */
static uint16_t label_of(const state *s, size_t site, int i)
{
    int32_t label = s->middle[site] + i - 1;
    return (uint16_t)(label < 0 ? 0 : label < (int32_t)s->labels ? label : label - 1);
}

/* Reads the costs of the labels near those of the labelling. */
static void read_costs(state *s)
{
    const qs_cost_source *source = &s->problem->source;
    size_t sites = (size_t)s->width * s->height;
    memcpy(s->middle, s->labelling, sites * sizeof *s->middle);
    for (uint32_t y = 0; y < s->height; y++) {
        size_t at = (size_t)s->width * y;
        uint16_t *row = s->labelling + at;
        for (int i = 0; i < NEAR; i++) {
            for (uint32_t x = 0; x < s->width; x++) {
                row[x] = label_of(s, at + x, i);
            }
            source->pick(source->context, y, row, s->costs[i] + at);
        }
        memcpy(row, s->middle + at, s->width * sizeof *row);
    }
}

/* What label i of a site costs beside the lines next to its own. */
static int64_t own_cost(const state *s, const line *on, size_t site, int i)
{
    uint32_t label = label_of(s, site, i);
    int64_t cost = s->costs[i][site];
    if (on->has_before) {
        size_t other = site - on->across;
        cost += between(s, weight_at(s, on->aside, other), label, s->labelling[other]);
    }
    if (on->has_after) {
        cost += between(s, weight_at(s, on->aside, site), label, s->labelling[site + on->across]);
    }
    return cost;
}

/* What a line costs up to a site: at least, with each of its labels there, and as it is. */
typedef struct line_costs {
    int64_t least[NEAR], kept;
} line_costs;

static int place_of(const state *s, size_t site)
{
    return s->labelling[site] - s->middle[site] + 1;
}

static line_costs begin_line(const state *s, const line *on)
{
    line_costs begun;
    for (int i = 0; i < NEAR; i++) {
        begun.least[i] = own_cost(s, on, on->first, i);
    }
    begun.kept = begun.least[place_of(s, on->first)];
    return begun;
}

/* Adds a site.
 *
 * from  out: the label of the site before that each label goes with */
static void go_on(const state *s, const line *on, size_t site, line_costs *costs,
                  uint8_t from[NEAR])
{
    size_t before = site - on->stride;
    int64_t weight = weight_at(s, on->ahead, before);
    line_costs next = {.kept = costs->kept +
                               between(s, weight, s->labelling[before], s->labelling[site])};
    for (int i = 0; i < NEAR; i++) {
        uint32_t label = label_of(s, site, i);
        int64_t best = INT64_MAX, own = own_cost(s, on, site, i);
        for (int j = 0; j < NEAR; j++) {
            int64_t cost = costs->least[j] + between(s, weight, label, label_of(s, before, j));
            from[i] = cost < best ? (uint8_t)j : from[i];
            best = cost < best ? cost : best;
        }
        next.least[i] = best + own;
        next.kept += i == place_of(s, site) ? own : 0;
    }
    *costs = next;
}

/* A line that cannot be made better stays as it is. */
static void solve_line(const state *s, const line *on)
{
    line_costs costs = begin_line(s, on);
    size_t site = on->first;
    int best = 0;
    for (size_t k = 1; k < on->count; k++) {
        site += on->stride;
        go_on(s, on, site, &costs, s->from + NEAR * k);
    }
    for (int i = 1; i < NEAR; i++) {
        best = costs.least[i] < costs.least[best] ? i : best;
    }
    for (size_t k = costs.least[best] < costs.kept ? on->count : 0; k-- > 0; site -= on->stride) {
        s->labelling[site] = label_of(s, site, best);
        best = k > 0 ? s->from[NEAR * k + (size_t)best] : best;
    }
}

static void solve_rows(const state *s)
{
    const qs_grid *grid = &s->problem->grid;
    for (uint32_t y = 0; y < s->height && qs_look_up(s->look, 9 * (uint64_t)s->width); y++) {
        solve_line(s, &(line){(size_t)s->width * y, 1, s->width, grid->right, grid->down, s->width,
                              y > 0, y + 1 < s->height});
    }
}

static void solve_columns(const state *s)
{
    const qs_grid *grid = &s->problem->grid;
    for (uint32_t x = 0; x < s->width && qs_look_up(s->look, 9 * (uint64_t)s->height); x++) {
        solve_line(s, &(line){x, s->width, s->height, grid->down, grid->right, 1, x > 0,
                              x + 1 < s->width});
    }
}

static int64_t energy_of(const state *s)
{
    int64_t energy = 0;
    for (size_t site = 0; site < (size_t)s->width * s->height; site++) {
        energy += s->costs[place_of(s, site)][site];
        if (site % s->width + 1 < s->width) {
            energy += between(s, weight_at(s, s->problem->grid.right, site), s->labelling[site],
                              s->labelling[site + 1]);
        }
        if (site / s->width + 1 < s->height) {
            energy += between(s, weight_at(s, s->problem->grid.down, site), s->labelling[site],
                              s->labelling[site + s->width]);
        }
    }
    return energy;
}

/* Returns false if the watch has stopped it, or nothing has become better. */
static bool iterate(state *s, qs_solution *solution)
{
    int64_t before = solution->energy;
    if (solution->iterations > 0) {
        read_costs(s);
    }
    solve_rows(s);
    solve_columns(s);
    solution->energy = energy_of(s);
    solution->converged = !s->look->stopped && solution->energy == before;
    solution->iterations += !s->look->stopped;
    return !s->look->stopped && !solution->converged;
}

static bool are_labels(const state *s)
{
    bool valid = true;
    for (size_t site = 0; site < (size_t)s->width * s->height; site++) {
        valid = valid && s->labelling[site] < s->labels;
    }
    return valid;
}

qs_status qs_near(const qs_problem *problem, const qs_solve_options *options, void *workspace,
                  size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!problem || !workspace || !labelling || !solution) {
        return QS_E_ARGUMENT;
    }
    qs_status status = qs_problem_check(problem);
    if (status != QS_OK || !is_for_us(problem)) {
        return status != QS_OK ? status : QS_E_ENCODING;
    }
    state s = state_of(problem);
    size_t size = take_parts(&s, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    s.labelling = labelling;
    if (!are_labels(&s)) {
        return QS_E_ARGUMENT;
    }
    qs_solution so_far = {.lower_bound = QS_NO_BOUND};
    qs_reporter reporter = {options, &so_far};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    s.look = &look;
    read_costs(&s);
    so_far.energy = energy_of(&s);
    while (iterate(&s, &so_far) && qs_report_progress(options, &so_far) &&
           !qs_limit_reached(options, &so_far, DEFAULT_ITERATIONS)) {
    }
    *solution = so_far;
    return QS_OK;
}
