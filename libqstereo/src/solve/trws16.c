/* TRW-S with costs of one byte and messages of two, straight from the problem: no model is laid
 * out. The passes are those of trws_passes.h, and so is the bound. Only the numbers are smaller. */
#include <string.h>

#include "../../include/qstereo/solve.h"
#include "../base/arena.h"
#include "../base/minmax.h"
#include "../base/simd.h"
#include "../problem/cost_strips.h"
#include "progress.h"
#include "trws16_avx2.h"

enum { DEFAULT_ITERATIONS = 2, MOST = QS_TRWS16_MOST, FINEST = 4, WAYS = 4, RUN = 16 };

typedef struct state {
    const qs_problem *problem;
    uint32_t width, height, sites, labels;
    uint32_t reach; /* labels further apart cost no more */
    int32_t heaviest; /* the largest weight of an edge */
    unsigned shift; /* messages are in units of 1 / 2^shift */
    int64_t least_sum; /* what was subtracted from the costs */
    int64_t first_sum; /* of the costs of label 0 */
    size_t pitch; /* from a site to the next in what follows: the labels, in whole runs */
    uint8_t *costs;
    /* Messages to or from the right, and below. A site of the former and a row of the latter stand
     * before the first ones, for the edges that end there. */
    int16_t *rows, *columns;
    uint32_t row_length; /* from a row to the next in `rows`; 0 = only one iteration is wanted. Then
                            all rows share the place of one, and a pass back makes those of the pass
                            before again, which takes less time than to keep them */
    uint32_t summed; /* the first row in which `columns` has sums for the labelling; only for
                        row_length 0 */
    uint32_t reached; /* rows from 0 that a pass has been to */
    int16_t *scratch; /* QS_TRWS16_ROWS of qs_trws16_row labels */
    void *strip;
    qs_look *look;
    bool wide; /* the processor has AVX2 */
    bool is_first; /* the pass in work is the first one */
} state;

static size_t take_parts(state *s, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t cells = (uint64_t)s->sites * s->pitch, row = (uint64_t)s->width * s->pitch;
    uint64_t in_rows = s->row_length > 0 ? cells : row;
    s->costs = qs_arena_take(&arena, cells, sizeof *s->costs);
    int16_t *rows = qs_arena_take(&arena, s->pitch + in_rows, sizeof *rows);
    int16_t *columns = qs_arena_take(&arena, row + cells, sizeof *columns);
    s->rows = rows ? rows + s->pitch : NULL;
    s->columns = columns ? columns + row : NULL;
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

static state state_of(const qs_problem *problem, uint64_t iterations)
{
    return (state){.problem = problem,
                   .width = problem->grid.width,
                   .height = problem->grid.height,
                   .sites = problem->grid.width * problem->grid.height,
                   .labels = problem->labels,
                   .pitch = ((size_t)problem->labels + RUN - 1) / RUN * RUN,
                   .row_length = iterations == 1 ? 0 : problem->grid.width,
                   .summed = problem->grid.height,
                   .reach = reach_of(problem)};
}

size_t qs_trws16_workspace(const qs_problem *problem, uint64_t iterations)
{
    if (!is_for_us(problem)) {
        return 0;
    }
    state counted = state_of(problem, iterations);
    return take_parts(&counted, NULL);
}

QS_KERNEL int32_t weight_of(const state *s, const int32_t *weights, uint32_t site)
{
    return weights ? weights[site] : s->problem->weight;
}

QS_KERNEL int32_t right_of(const state *s, uint32_t x, uint32_t site)
{
    return x + 1 < s->width ? weight_of(s, s->problem->grid.right, site) : 0;
}

QS_KERNEL int32_t below_of(const state *s, uint32_t y, uint32_t site)
{
    return y + 1 < s->height ? weight_of(s, s->problem->grid.down, site) : 0;
}

QS_KERNEL int32_t left_of(const state *s, uint32_t x, uint32_t site)
{
    return x > 0 ? weight_of(s, s->problem->grid.right, site - 1) : 0;
}

QS_KERNEL int32_t above_of(const state *s, uint32_t y, uint32_t site)
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

/* The processor can, and the registers and the rounds of the lower envelope are few enough. */
static bool is_wide(const state *s)
{
#if QS_HAVE_AVX2
    return s->pitch <= RUN * QS_TRWS16_RUNS && s->reach <= QS_TRWS16_REACH && qs_lanes_avx2();
#else
    (void)s;
    return false;
#endif
}

/* Scratch has large numbers beside the labels, which the lower envelope may look at. */
static void fill_scratch(const state *s)
{
    for (uint64_t i = 0; i < QS_TRWS16_ROWS * qs_trws16_row(s->labels); i++) {
        s->scratch[i] = MOST;
    }
}

static bool put_words(uint8_t *restrict to, const uint32_t *restrict from, uint32_t labels)
{
    uint32_t most = 0;
    for (uint32_t d = 0; d < labels; d++) {
        most |= from[d];
        to[d] = (uint8_t)from[d];
    }
    return most <= UINT8_MAX;
}

/* The costs of a strip, at their pitch. Returns false if one takes more than a byte. */
static bool put_costs(const state *s, const qs_strip *strip, uint8_t *to)
{
    bool fit = true;
    for (uint32_t i = 0; fit && i < strip->sites; i++, to += s->pitch) {
        size_t from = (size_t)i * s->labels;
        if (strip->bytes == 1) {
            memcpy(to, (const uint8_t *)strip->costs + from, s->labels);
        } else {
            fit = put_words(to, (const uint32_t *)strip->costs + from, s->labels);
        }
        memset(to + s->labels, 0, s->pitch - s->labels);
    }
    return fit;
}

/* Returns false if a cost takes more than a byte. Those that come as they are to stand are made at
 * their place. */
static bool read_costs(state *s)
{
    uint8_t *to = s->costs;
    qs_strip strip = qs_strip_first(s->problem, s->strip);
    bool straight = strip.bytes == 1 && s->pitch == s->labels, more = true, fit = true;
    while (fit) {
        strip.costs = straight ? to : strip.costs;
        more = qs_strip_next(&strip);
        if (!more) {
            break;
        }
        fit = straight || put_costs(s, &strip, to);
        for (uint32_t i = 0; i < strip.sites; i++, to += s->pitch) {
            s->first_sum += to[0];
        }
        s->least_sum += strip.least_sum;
    }
    return fit;
}

QS_KERNEL int16_t *row_at(const state *s, uint32_t x, uint32_t y)
{
    return s->rows + ((size_t)y * s->row_length + x) * s->pitch;
}

QS_KERNEL int16_t *column_at(const state *s, uint32_t site)
{
    return s->columns + site * s->pitch;
}

/* What a pass reads and writes at a site: as qs_visit_of in trws_visit.h. */
QS_KERNEL qs_trws16_visit visit_of(const state *s, uint32_t x, uint32_t y, bool forward)
{
    uint32_t site = y * s->width + x;
    size_t pitch = s->pitch;
    int32_t right = right_of(s, x, site), below = below_of(s, y, site), left = left_of(s, x, site),
            above = above_of(s, y, site);
    int16_t *own = row_at(s, x, y), *before = own - pitch, *under = column_at(s, site),
            *over = under - pitch * s->width;
    int32_t row = forward ? right : left, column = forward ? below : above;
    bool both = (left != 0 && above != 0) || (right != 0 && below != 0);
    return (qs_trws16_visit){
        .costs = s->costs + pitch * site,
        .row_in = forward ? before : own,
        .row_out = forward ? own : before,
        .column_in = forward ? over : under,
        .column_out = forward ? under : over,
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
        const char *costs = (const char *)(s->costs + s->pitch * ahead),
                   *columns = (const char *)column_at(s, ahead);
        for (uint32_t i = 0; i < s->labels; i += LINE) {
            __builtin_prefetch(costs + i);
        }
        for (uint32_t i = 0; i < 2 * s->labels; i += LINE) {
            __builtin_prefetch(columns + i);
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

/* A part of a pass: a row of it. */
typedef struct stretch {
    uint32_t y;
    bool forward;
    bool again; /* only the messages along the row, as they were; they add nothing to the bound */
} stretch;

QS_KERNEL qs_trws16_visit visit_at(const state *s, const stretch *of, uint32_t x)
{
    qs_trws16_visit v = visit_of(s, x, of->y, of->forward);
    v.row_only = of->again;
    if (s->row_length == 0 && !of->forward) {
        v.sums = column_at(s, of->y * s->width + x);
    }
    return v;
}

static int64_t plain_row(const state *s, const stretch *of)
{
    const qs_trws16_rule rule = rule_of(s);
    int64_t bound = 0;
    for (uint32_t i = 0; i < s->width; i++) {
        qs_trws16_visit v = visit_at(s, of, of->forward ? i : s->width - 1 - i);
        bound += qs_trws16_visit_site(&rule, &v);
    }
    return bound;
}

#if QS_HAVE_AVX2
QS_WIDE int64_t row_of_runs(const state *s, const stretch *of, uint32_t runs, bool is_first)
{
    const qs_trws16_rule rule = rule_of(s);
    int64_t bound = 0;
    for (uint32_t i = 0; i < s->width; i++) {
        uint32_t x = of->forward ? i : s->width - 1 - i;
        qs_trws16_visit v = visit_at(s, of, x);
        fetch(s, of->y * s->width + x, of->forward);
        bound += qs_trws16_visit_lanes(&rule, &v, runs, is_first);
    }
    return bound;
}

QS_AVX2 static int64_t wide_row(const state *s, const stretch *of)
{
    enum { FEW = 2, SOME = 4, MANY = 8 }; /* of which a compiler makes code of their own */
    uint32_t runs = (uint32_t)(s->pitch / RUN);
    switch (runs) {
    case FEW: return s->is_first ? row_of_runs(s, of, FEW, true) : row_of_runs(s, of, FEW, false);
    case SOME:
        return s->is_first ? row_of_runs(s, of, SOME, true) : row_of_runs(s, of, SOME, false);
    case MANY:
        return s->is_first ? row_of_runs(s, of, MANY, true) : row_of_runs(s, of, MANY, false);
    default: return row_of_runs(s, of, runs, s->is_first);
    }
}
#endif

static int64_t pass_row(const state *s, const stretch *of)
{
#if QS_HAVE_AVX2
    return s->wide ? wide_row(s, of) : plain_row(s, of);
#else
    return plain_row(s, of);
#endif
}

static bool looks_up(const state *s)
{
    return qs_look_up(s->look, 2 * (uint64_t)s->width * s->labels);
}

/* Makes the messages along a row as the pass forward has made them. */
static void make_again(state *s, uint32_t y)
{
    s->is_first = true;
    (void)pass_row(s, &(stretch){y, true, true});
    s->is_first = false;
}

/* Returns the bound, in units of 1 / 2^shift; there is none if the watch stops the pass. */
static int64_t pass(state *s, bool forward)
{
    int64_t bound = 0;
    for (uint32_t i = 0; i < s->height && looks_up(s); i++) {
        uint32_t y = forward ? i : s->height - 1 - i;
        if (s->row_length == 0 && !forward) {
            make_again(s, y);
            s->summed = y;
        }
        bound += pass_row(s, &(stretch){y, forward, false});
        s->reached = qs_max_u32(s->reached, y + 1);
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
            energy += s->costs[p * s->pitch + labelling[p]];
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
        s->costs + site * s->pitch,
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

/* The costs of a site and the messages of the later neighbours. Where a pass that was stopped has
 * not been, there are no messages. */
QS_KERNEL const int16_t *sums_of(const state *s, uint32_t x, uint32_t y)
{
    uint32_t site = y * s->width + x;
    if (y >= s->summed) {
        return column_at(s, site);
    }
    bool met = s->row_length > 0 && y < s->reached;
    const uint8_t *costs = s->costs + s->pitch * site;
    const int16_t *row = row_at(s, x, y), *column = column_at(s, site);
    int16_t *sums = s->scratch + qs_trws16_row(s->labels);
    for (size_t d = 0, end = s->wide ? s->pitch : s->labels; d < end; d++) {
        int32_t cost = costs[d] << s->shift;
        sums[d] = (int16_t)(met ? cost + row[d] + column[d] : cost);
    }
    return sums;
}

/* In a pass back the later neighbours are those to the left and above: they have labels. */
QS_KERNEL qs_trws16_beside beside_of(const state *s, uint32_t x, uint32_t y,
                                     const uint16_t *labelling)
{
    uint32_t site = y * s->width + x, unit = 1u << s->shift;
    return (qs_trws16_beside){labelling[x > 0 ? site - 1 : site],
                              labelling[y > 0 ? site - s->width : site],
                              (int16_t)(left_of(s, x, site) * (int32_t)unit),
                              (int16_t)(above_of(s, y, site) * (int32_t)unit)};
}

static void plain_labels(const state *s, uint32_t y, uint16_t *labelling)
{
    const qs_trws16_rule rule = rule_of(s);
    for (uint32_t x = 0; x < s->width; x++) {
        const qs_trws16_beside near = beside_of(s, x, y, labelling);
        labelling[y * s->width + x] = qs_trws16_label(&rule, sums_of(s, x, y), &near);
    }
}

#if QS_HAVE_AVX2
QS_WIDE void labels_of_runs(const state *s, uint32_t y, uint16_t *labelling, uint32_t runs)
{
    const qs_trws16_rule rule = rule_of(s);
    for (uint32_t x = 0; x < s->width; x++) {
        const qs_trws16_beside near = beside_of(s, x, y, labelling);
        labelling[y * s->width + x] = qs_trws16_label_lanes(&rule, sums_of(s, x, y), &near, runs);
    }
}

QS_AVX2 static void wide_labels(const state *s, uint32_t y, uint16_t *labelling)
{
    enum { SOME = 4 };
    uint32_t runs = (uint32_t)(s->pitch / RUN);
    if (runs == SOME) {
        labels_of_runs(s, y, labelling, SOME);
    } else {
        labels_of_runs(s, y, labelling, runs);
    }
}
#endif

static void label_row(const state *s, uint32_t y, uint16_t *labelling)
{
#if QS_HAVE_AVX2
    if (s->wide) {
        wide_labels(s, y, labelling);
        return;
    }
#endif
    plain_labels(s, y, labelling);
}

/* A labelling in the order of the sites, each with the labels of those before it and the messages
 * of those after it. */
static void make_labels(const state *s, uint16_t *labelling)
{
    for (uint32_t y = 0; y < s->height; y++) {
        label_row(s, y, labelling);
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
    state s = state_of(problem, options ? options->iterations : 0);
    size_t size = take_parts(&s, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    s.wide = is_wide(&s);
    if (!choose_shift(&s) || !read_costs(&s)) {
        return QS_E_OVERFLOW;
    }
    fill_scratch(&s);
    memset(labelling, 0, sizeof *labelling * s.sites);
    qs_solution so_far = {.energy = s.least_sum + s.first_sum, .lower_bound = s.least_sum};
    qs_reporter reporter = {options, &so_far};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    s.look = &look;
    memset(s.rows - s.pitch, 0, sizeof *s.rows * s.pitch);
    memset(s.columns - s.pitch * s.width, 0, sizeof *s.columns * s.pitch * s.width);
    solve(&s, options, labelling, &so_far);
    *solution = so_far;
    return QS_OK;
}
