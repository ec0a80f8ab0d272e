/* TRW-S with costs of one byte and messages of two, straight from the problem: no model is laid
 * out. The passes are those of trws_passes.h, and so is the bound. Only the numbers are smaller. */
#include <string.h>

#include "../../include/qstereo/solve.h"
#include "../base/arena.h"
#include "../base/minmax.h"
#include "../base/simd.h"
#include "../problem/cost_strips.h"
#include "progress.h"
#include "trws16_site.h"

enum { DEFAULT_ITERATIONS = 2, MOST = 1 << 14, FINEST = 4, WAYS = 4 };

typedef struct state {
    const qs_problem *problem;
    uint32_t width, height, sites, labels;
    uint32_t reach; /* labels further apart cost no more */
    int32_t heaviest; /* the largest weight of an edge */
    unsigned shift; /* messages are in units of 1 / 2^shift */
    int64_t least_sum; /* what was subtracted from the costs */
    int64_t first_sum; /* of the costs of label 0 */
    uint8_t *costs; /* sites x labels */
    int16_t *messages; /* of each site: to or from the right, then below. A row of them stands
                          before the first site, for the edges that end there */
    int16_t *scratch; /* QS_TRWS16_ROWS of qs_trws16_row labels */
    void *strip;
    qs_look *look;
    bool wide; /* the processor has AVX2 */
    bool is_first; /* the pass in work is the first one */
} state;

static size_t take_parts(state *s, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t cells = (uint64_t)s->sites * s->labels, padding = 2 * (uint64_t)s->width * s->labels;
    s->costs = qs_arena_take(&arena, cells, sizeof *s->costs);
    int16_t *padded = qs_arena_take(&arena, padding + 2 * cells, sizeof *padded);
    s->messages = padded ? padded + padding : NULL;
    s->scratch =
        qs_arena_take(&arena, QS_TRWS16_ROWS * qs_trws16_row(s->labels), sizeof *s->scratch);
    s->strip = qs_arena_take(&arena, qs_costs_workspace(s->problem), 1);
    return qs_arena_size(&arena);
}

static bool is_for_us(const qs_problem *problem)
{
    const qs_pairwise *v = &problem->pairwise;
    return problem->grid.width > 0 && !problem->grid.mask && !problem->allowed &&
           (v->smoothness == QS_POTTS || v->smoothness == QS_TRUNCATED_LINEAR);
}

static uint32_t reach_of(const qs_problem *problem)
{
    uint32_t most = qs_max_u32(problem->labels, 2) - 1, cut = problem->pairwise.truncation;
    if (problem->pairwise.smoothness == QS_POTTS) {
        return 1;
    }
    return cut > 0 ? qs_min_u32(cut, most) : most;
}

static state state_of(const qs_problem *problem)
{
    return (state){.problem = problem,
                   .width = problem->grid.width,
                   .height = problem->grid.height,
                   .sites = problem->grid.width * problem->grid.height,
                   .labels = problem->labels,
                   .reach = reach_of(problem)};
}

size_t qs_trws16_workspace(const qs_problem *problem)
{
    if (!is_for_us(problem)) {
        return 0;
    }
    state counted = state_of(problem);
    return take_parts(&counted, NULL);
}

static int32_t weight_of(const state *s, const int32_t *weights, uint32_t site)
{
    return weights ? weights[site] : s->problem->weight;
}

static int32_t right_of(const state *s, uint32_t x, uint32_t site)
{
    return x + 1 < s->width ? weight_of(s, s->problem->grid.right, site) : 0;
}

static int32_t below_of(const state *s, uint32_t y, uint32_t site)
{
    return y + 1 < s->height ? weight_of(s, s->problem->grid.down, site) : 0;
}

static int32_t left_of(const state *s, uint32_t x, uint32_t site)
{
    return x > 0 ? weight_of(s, s->problem->grid.right, site - 1) : 0;
}

static int32_t above_of(const state *s, uint32_t y, uint32_t site)
{
    return y > 0 ? weight_of(s, s->problem->grid.down, site - s->width) : 0;
}

/* Finds the finest messages for which all sums fit. */
static bool choose_shift(state *s)
{
    s->heaviest = 0;
    for (uint32_t p = 0; p < s->sites; p++) {
        int32_t right = right_of(s, p % s->width, p), below = below_of(s, p / s->width, p);
        s->heaviest = qs_max_i32(s->heaviest, qs_max_i32(right, below));
    }
    uint64_t labels = s->labels, most = UINT8_MAX + WAYS * (uint64_t)s->heaviest * s->reach;
    for (s->shift = 0; s->shift < FINEST && most << (s->shift + 1) < MOST; s->shift++) {
    }
    return most < MOST && labels < MOST;
}

/* Scratch has large numbers beside the labels, which the lower envelope may look at. */
static void fill_scratch(const state *s)
{
    for (uint64_t i = 0; i < QS_TRWS16_ROWS * qs_trws16_row(s->labels); i++) {
        s->scratch[i] = MOST;
    }
}

static bool put_costs(uint8_t *restrict to, const uint32_t *restrict from, size_t count)
{
    uint32_t most = 0;
    for (size_t i = 0; i < count; i++) {
        most |= from[i];
        to[i] = (uint8_t)from[i];
    }
    return most <= UINT8_MAX;
}

/* Returns false if a cost takes more than a byte. */
static bool read_costs(state *s)
{
    uint8_t *to = s->costs;
    bool fit = true;
    for (qs_strip strip = qs_strip_first(s->problem, s->strip); fit && qs_strip_next(&strip);) {
        size_t count = (size_t)strip.sites * s->labels;
        if (strip.bytes == 1) {
            memcpy(to, strip.costs, count);
        } else {
            fit = put_costs(to, strip.costs, count);
        }
        for (size_t at = 0; at < count; at += s->labels) {
            s->first_sum += to[at];
        }
        to += count;
        s->least_sum += strip.least_sum;
    }
    return fit;
}

/* What a pass reads and writes at a site: as qs_visit_of in trws_visit.h. */
static qs_trws16_visit visit_of(const state *s, uint32_t x, uint32_t y, bool forward)
{
    uint32_t site = y * s->width + x;
    size_t labels = s->labels;
    int32_t right = right_of(s, x, site), below = below_of(s, y, site), left = left_of(s, x, site),
            above = above_of(s, y, site);
    int16_t *own = s->messages + 2 * labels * site, *before = own - 2 * labels,
            *over = own - 2 * labels * s->width + labels;
    int32_t row = forward ? right : left, column = forward ? below : above;
    bool both = (left != 0 && above != 0) || (right != 0 && below != 0);
    return (qs_trws16_visit){
        .costs = s->costs + labels * site,
        .row_in = forward ? before : own,
        .row_out = forward ? own : before,
        .column_in = forward ? over : own + labels,
        .column_out = forward ? own + labels : over,
        .row_weight = (int16_t)(row * (1 << s->shift)),
        .column_weight = (int16_t)(column * (1 << s->shift)),
        .row_share = both || row != 0 || column == 0 ? -1 : 0,
        .both = both,
    };
}

/* Has memory fetched that the pass needs soon. */
QS_KERNEL void fetch(const state *s, uint32_t site, bool forward)
{
#if QS_HAVE_AVX2
    enum { AHEAD = 6, LINE = 64 };
    uint32_t ahead = forward ? site + AHEAD : site - AHEAD;
    if (ahead < s->sites) {
        const char *costs = (const char *)(s->costs + (size_t)s->labels * ahead),
                   *messages = (const char *)(s->messages + 2 * (size_t)s->labels * ahead);
        for (uint32_t i = 0; i < s->labels; i += LINE) {
            __builtin_prefetch(costs + i);
        }
        for (uint32_t i = 0; i < 4 * s->labels; i += LINE) {
            __builtin_prefetch(messages + i);
        }
    }
#else
    (void)s;
    (void)site;
    (void)forward;
#endif
}

QS_KERNEL qs_trws16_rule rule_of(const state *s)
{
    return (qs_trws16_rule){s->labels, s->reach, (int16_t)(1 << s->shift), s->is_first, s->scratch};
}

QS_KERNEL int64_t pass_row(const state *s, uint32_t y, bool forward)
{
    const qs_trws16_rule rule = rule_of(s);
    int64_t bound = 0;
    for (uint32_t i = 0; i < s->width; i++) {
        uint32_t x = forward ? i : s->width - 1 - i;
        qs_trws16_visit v = visit_of(s, x, y, forward);
        fetch(s, y * s->width + x, forward);
        bound += qs_trws16_visit_site(&rule, &v);
    }
    return bound;
}

static int64_t plain_row(const state *s, uint32_t y, bool forward)
{
    return pass_row(s, y, forward);
}

QS_AVX2 static int64_t wide_row(const state *s, uint32_t y, bool forward)
{
    return pass_row(s, y, forward);
}

static bool looks_up(const state *s)
{
    return qs_look_up(s->look, 2 * (uint64_t)s->width * s->labels);
}

/* Returns the bound, in units of 1 / 2^shift; there is none if the watch stops the pass. */
static int64_t pass(state *s, bool forward)
{
    int64_t bound = 0;
    for (uint32_t i = 0; i < s->height && looks_up(s); i++) {
        uint32_t y = forward ? i : s->height - 1 - i;
        bound += s->wide ? wide_row(s, y, forward) : plain_row(s, y, forward);
    }
    return bound;
}

static int32_t apart(const state *s, uint16_t a, uint16_t b)
{
    uint32_t off = a > b ? (uint32_t)(a - b) : (uint32_t)(b - a);
    return (int32_t)qs_min_u32(off, s->reach);
}

static int64_t energy_of(const state *s, const uint16_t *labelling)
{
    int64_t energy = s->least_sum;
    for (uint32_t y = 0, p = 0; y < s->height; y++) {
        for (uint32_t x = 0; x < s->width; x++, p++) {
            energy += s->costs[(size_t)p * s->labels + labelling[p]];
            if (x + 1 < s->width) {
                energy += right_of(s, x, p) * apart(s, labelling[p], labelling[p + 1]);
            }
            if (y + 1 < s->height) {
                energy += below_of(s, y, p) * apart(s, labelling[p], labelling[p + s->width]);
            }
        }
    }
    return energy;
}

/* A site with its neighbours. Where there is none, the weight is 0 and the label its own. */
typedef struct around {
    const uint8_t *costs;
    int32_t weights[WAYS];
    uint16_t labels[WAYS];
} around;

static around around_of(const state *s, uint32_t x, uint32_t y, const uint16_t *labelling)
{
    uint32_t site = y * s->width + x;
    const uint16_t *own = labelling + site;
    return (around){
        s->costs + (size_t)site * s->labels,
        {left_of(s, x, site), right_of(s, x, site), above_of(s, y, site), below_of(s, y, site)},
        {own[x > 0 ? -1 : 0], own[x + 1 < s->width], *(y > 0 ? own - s->width : own),
         own[y + 1 < s->height ? s->width : 0]}};
}

static int32_t cost_beside(const state *s, const around *near, uint16_t label)
{
    int32_t cost = near->costs[label];
    for (int i = 0; i < WAYS; i++) {
        cost += near->weights[i] * apart(s, label, near->labels[i]);
    }
    return cost;
}

/* Lets a site take the label of a neighbour if that is cheaper. */
static void take_from_neighbours(const state *s, uint32_t x, uint32_t y, uint16_t *own,
                                 const uint16_t *labelling)
{
    const around near = around_of(s, x, y, labelling);
    int32_t least = cost_beside(s, &near, *own);
    uint16_t best = *own;
    for (int i = 0; i < WAYS; i++) {
        int32_t cost = near.labels[i] != best ? cost_beside(s, &near, near.labels[i]) : least;
        best = cost < least ? near.labels[i] : best;
        least = qs_min_i32(least, cost);
    }
    *own = best;
}

/* Once over the sites that do not have the labels of all neighbours. */
static void improve(const state *s, uint16_t *labelling)
{
    uint16_t *own = labelling;
    for (uint32_t y = 0; y < s->height; y++) {
        size_t up = y > 0 ? s->width : 0, down = y + 1 < s->height ? s->width : 0;
        for (uint32_t x = 0; x < s->width; x++, own++) {
            if (own[0] != own[x + 1 < s->width] || own[0] != *(own - (x > 0)) ||
                own[0] != *(own - up) || own[0] != own[down]) {
                take_from_neighbours(s, x, y, own, labelling);
            }
        }
    }
}

QS_KERNEL void label_row(const state *s, uint32_t y, uint16_t *labelling)
{
    const qs_trws16_rule rule = rule_of(s);
    for (uint32_t x = 0; x < s->width; x++) {
        uint32_t site = y * s->width + x;
        const qs_trws16_visit v = visit_of(s, x, y, false);
        /* In a pass back these are the edges to the left and above: labels that stand already. */
        uint16_t left = labelling[x > 0 ? site - 1 : site],
                 above = labelling[y > 0 ? site - s->width : site];
        labelling[site] = qs_trws16_label(&rule, &v, left, above);
    }
}

static void plain_labels(const state *s, uint32_t y, uint16_t *labelling)
{
    label_row(s, y, labelling);
}

QS_AVX2 static void wide_labels(const state *s, uint32_t y, uint16_t *labelling)
{
    label_row(s, y, labelling);
}

/* A labelling in the order of the sites, each with the labels of those before it and the messages
 * of those after it. */
static void make_labels(const state *s, uint16_t *labelling)
{
    for (uint32_t y = 0; y < s->height; y++) {
        if (s->wide) {
            wide_labels(s, y, labelling);
        } else {
            plain_labels(s, y, labelling);
        }
    }
}

static void raise_bound(const state *s, int64_t bound, qs_solution *solution)
{
    int64_t unit = (int64_t)1 << s->shift, whole = bound / unit;
    whole += bound > whole * unit;
    solution->lower_bound = qs_max_i64(solution->lower_bound, whole + s->least_sum);
}

/* A pass forward and one back. Returns false if the watch has stopped them. */
static bool iterate(state *s, qs_solution *solution)
{
    for (int way = 0; way < 2; way++) {
        s->is_first = way == 0 && solution->iterations == 0;
        int64_t bound = pass(s, way == 0);
        if (s->look->stopped) {
            return false;
        }
        raise_bound(s, bound, solution);
    }
    solution->iterations++;
    return true;
}

static void solve(state *s, const qs_solve_options *options, uint16_t *labelling,
                  qs_solution *solution)
{
    bool go = true;
    while (go && iterate(s, solution)) {
        go = qs_report_progress(options, solution) &&
             !qs_limit_reached(options, solution, DEFAULT_ITERATIONS);
    }
    make_labels(s, labelling);
    improve(s, labelling);
    solution->energy = energy_of(s, labelling);
    solution->converged = solution->energy == solution->lower_bound;
    (void)qs_report_progress(options, solution);
}

qs_status qs_trws16(const qs_problem *problem, const qs_solve_options *options, void *workspace,
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
    s.wide = qs_lanes_avx2();
    if (!choose_shift(&s) || !read_costs(&s)) {
        return QS_E_OVERFLOW;
    }
    fill_scratch(&s);
    memset(labelling, 0, sizeof *labelling * s.sites);
    qs_solution so_far = {.energy = s.least_sum + s.first_sum, .lower_bound = s.least_sum};
    qs_reporter reporter = {options, &so_far};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    s.look = &look;
    size_t before = 2 * (size_t)s.width * s.labels;
    memset(s.messages - before, 0, sizeof *s.messages * before);
    solve(&s, options, labelling, &so_far);
    *solution = so_far;
    return QS_OK;
}
