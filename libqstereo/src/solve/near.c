/* A labelling made better by labels near its own: lines of the grid, one after the other, each
 * solved exactly beside the labels of the lines next to it. */
#include <string.h>

#include "../../include/qstereo/solve.h"
#include "../base/arena.h"
#include "../base/minmax.h"
#include "progress.h"
#include "straight.h"

enum { NEAR = 3, DEFAULT_ITERATIONS = 1 };

/* More than any line costs: of a label that there is not. */
static const int64_t NEVER = INT64_MAX / 4;

/* A site: its labels are middle - 1, middle and middle + 1, of which the first or the last one may
 * not be there. Sites of a column, like those of a row, are few lines of the cache. */
typedef struct spot {
    int32_t costs[NEAR];
    uint16_t middle;
} spot;

typedef struct state {
    const qs_problem *problem;
    uint32_t width, height, labels;
    uint32_t reach; /* labels further apart cost no more */
    uint16_t *labelling;
    spot *spots;
    int32_t *picked; /* costs of a row */
    uint8_t *from; /* of a line's sites: the label of the one before that each label goes with, two
                      bits each */
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
    s->spots = qs_arena_take(&arena, sites, sizeof *s->spots);
    s->picked = qs_arena_take(&arena, s->width, sizeof *s->picked);
    s->from = qs_arena_take(&arena, qs_max_u32(s->width, s->height), sizeof *s->from);
    return qs_arena_size(&arena);
}

/* The costs of single labels can be had. */
static bool can_pick(const qs_problem *problem)
{
    return problem->source.pick && !problem->costs;
}

static state state_of(const qs_problem *problem)
{
    return (state){.problem = problem,
                   .width = problem->grid.width,
                   .height = problem->grid.height,
                   .labels = problem->labels,
                   .reach = qs_straight_reach(problem)};
}

size_t qs_near_workspace(const qs_problem *problem)
{
    if (!qs_straight_takes(problem) || !can_pick(problem)) {
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

/* The label before or behind the middle one; where there is none, the middle one. */
static uint16_t label_near(const state *s, uint16_t middle, int i)
{
    int32_t label = middle + i - 1;
    return (uint16_t)(label < 0 ? 0 : label < (int32_t)s->labels ? label : label - 1);
}

/* Reads the costs of the labels near those of the labelling. */
static void read_costs(state *s)
{
    const qs_cost_source *source = &s->problem->source;
    for (uint32_t y = 0; y < s->height; y++) {
        uint16_t *row = s->labelling + (size_t)s->width * y;
        spot *spots = s->spots + (size_t)s->width * y;
        for (uint32_t x = 0; x < s->width; x++) {
            spots[x].middle = row[x];
        }
        for (int i = 0; i < NEAR; i++) {
            for (uint32_t x = 0; x < s->width; x++) {
                row[x] = label_near(s, spots[x].middle, i);
            }
            source->pick(source->context, y, row, s->picked);
            for (uint32_t x = 0; x < s->width; x++) {
                spots[x].costs[i] = s->picked[x];
            }
        }
        for (uint32_t x = 0; x < s->width; x++) {
            row[x] = spots[x].middle;
        }
    }
}

/* Adds what the labels cost beside one of a line next to theirs. */
static void add_beside(const state *s, int64_t weight, int32_t middle, int32_t other,
                       int64_t own[NEAR])
{
    for (int i = 0; i < NEAR; i++) {
        own[i] += between(s, weight, (uint32_t)(middle + i), (uint32_t)(other + 1));
    }
}

/* What the labels of a site cost beside the lines next to its own. */
static void own_costs(const state *s, const line *on, size_t site, int64_t own[NEAR])
{
    const spot *at = &s->spots[site];
    for (int i = 0; i < NEAR; i++) {
        own[i] = at->costs[i];
    }
    own[0] += at->middle == 0 ? NEVER : 0;
    own[NEAR - 1] += at->middle + 1u == s->labels ? NEVER : 0;
    if (on->has_before) {
        size_t other = site - on->across;
        add_beside(s, weight_at(s, on->aside, other), at->middle, s->labelling[other], own);
    }
    if (on->has_after) {
        size_t other = site + on->across;
        add_beside(s, weight_at(s, on->aside, site), at->middle, s->labelling[other], own);
    }
}

/* What a line costs up to a site: at least, with each of its labels there, and as it is. */
typedef struct line_costs {
    int64_t least[NEAR], kept;
} line_costs;

static int place_of(const state *s, size_t site)
{
    return s->labelling[site] - s->spots[site].middle + 1;
}

static line_costs begin_line(const state *s, const line *on)
{
    line_costs begun;
    own_costs(s, on, on->first, begun.least);
    begun.kept = begun.least[place_of(s, on->first)];
    return begun;
}

/* Adds a site. Returns the label of the site before that each of its labels goes with. */
static uint8_t go_on(const state *s, const line *on, size_t site, line_costs *costs)
{
    enum { APART = 2 * NEAR - 1 }; /* by how much the places of two labels may differ */
    size_t before = site - on->stride;
    int32_t off = s->spots[site].middle - s->spots[before].middle - (NEAR - 1);
    int64_t weight = weight_at(s, on->ahead, before), own[NEAR], edge[APART];
    unsigned from = 0;
    own_costs(s, on, site, own);
    for (int k = 0; k < APART; k++) {
        uint32_t apart = (uint32_t)(off + k < 0 ? -off - k : off + k);
        edge[k] = weight * qs_min_u32(apart, s->reach);
    }
    line_costs next = {.kept = costs->kept + own[place_of(s, site)] +
                               edge[place_of(s, site) - place_of(s, before) + NEAR - 1]};
    for (int i = 0; i < NEAR; i++) {
        int64_t best = costs->least[0] + edge[i + NEAR - 1];
        unsigned with = 0;
        for (int j = 1; j < NEAR; j++) {
            int64_t cost = costs->least[j] + edge[i - j + NEAR - 1];
            with = cost < best ? (unsigned)j : with;
            best = cost < best ? cost : best;
        }
        next.least[i] = best + own[i];
        from |= with << (2 * i);
    }
    *costs = next;
    return (uint8_t)from;
}

/* A line that cannot be made better stays as it is. */
static void solve_line(const state *s, const line *on)
{
    line_costs costs = begin_line(s, on);
    size_t site = on->first;
    int best = 0;
    for (size_t k = 1; k < on->count; k++) {
        site += on->stride;
        s->from[k] = go_on(s, on, site, &costs);
    }
    for (int i = 1; i < NEAR; i++) {
        best = costs.least[i] < costs.least[best] ? i : best;
    }
    for (size_t k = costs.least[best] < costs.kept ? on->count : 0; k-- > 0; site -= on->stride) {
        s->labelling[site] = (uint16_t)(s->spots[site].middle + best - 1);
        best = k > 0 ? s->from[k] >> (2 * best) & 3 : best;
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
        energy += s->spots[site].costs[place_of(s, site)];
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
    qs_status status = qs_straight_check(problem, workspace, labelling, solution);
    if (status != QS_OK || !can_pick(problem)) {
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
