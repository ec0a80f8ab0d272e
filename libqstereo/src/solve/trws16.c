/* TRW-S with costs of one byte and messages of two, straight from the problem: no model is laid
 * out. The passes are those of trws_passes.h, and so is the bound. Only the numbers are smaller. */
#include <string.h>

#include "../base/arena.h"
#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../problem/cost_strips.h"
#include "straight.h"
#include "trws16_state.h"
#include "trws16_wave.h"

enum { DEFAULT_ITERATIONS = 2, MOST = QS_TRWS16_MOST, FINEST = 4, WAYS = 4 };

typedef qs_trws16_state state;

static bool costs_stand(const state *s)
{
    return s->problem->source.bytes == 1 && s->pitch == s->labels;
}

/* Parts that may read costs at the same time. */
static uint32_t readers_of(const state *s)
{
    uint32_t copies = s->problem->costs ? 1 : s->problem->source.copies;
    return qs_min_u32(qs_max_u32(copies, 1), QS_TRWS16_PARTS);
}

/* Bytes that leave what follows aligned. */
static uint64_t whole(uint64_t bytes)
{
    return (bytes + QS_ARENA_ALIGNMENT - 1) / QS_ARENA_ALIGNMENT * QS_ARENA_ALIGNMENT;
}

static uint64_t least_size(const state *s)
{
    return whole(sizeof(int32_t) * (uint64_t)s->width);
}

/* Of a part that reads costs: the least ones of a row, and a row of them if they do not stand at
 * once. */
static size_t strip_size(const state *s)
{
    uint64_t row = (uint64_t)s->width * s->labels * s->problem->source.bytes;
    return s->problem->costs ? qs_costs_workspace(s->problem)
                             : qs_size(least_size(s) + (costs_stand(s) ? 0 : whole(row)));
}

static size_t take_parts(state *s, void *workspace)
{
    qs_arena arena = {.base = workspace};
    uint64_t cells = (uint64_t)s->sites * s->pitch, row = (uint64_t)s->width * s->pitch;
    s->costs = qs_arena_take(&arena, cells, sizeof *s->costs);
    s->rows = qs_arena_take(&arena, (row + s->pitch) * s->row_count, sizeof *s->rows);
    int16_t *columns = qs_arena_take(&arena, row + cells, sizeof *columns);
    s->columns = columns ? columns + row : NULL;
    s->scratch =
        qs_arena_take(&arena, QS_TRWS16_PARTS * qs_trws16_scratch(s->labels), sizeof *s->scratch);
    s->strip_size = strip_size(s);
    s->strip = qs_arena_take(&arena, readers_of(s), s->strip_size);
    return qs_arena_size(&arena);
}

static state state_of(const qs_problem *problem, uint64_t iterations)
{
    uint32_t height = problem->grid.height;
    return (state){.problem = problem,
                   .width = problem->grid.width,
                   .height = height,
                   .sites = problem->grid.width * height,
                   .labels = problem->labels,
                   .pitch = ((size_t)problem->labels + QS_TRWS16_RUN - 1) / QS_TRWS16_RUN *
                            QS_TRWS16_RUN,
                   .is_once = iterations == 1,
                   .row_count = iterations == 1 ? qs_min_u32(height, QS_TRWS16_FLIGHT) : height,
                   .summed = height,
                   .reach = qs_straight_reach(problem)};
}

size_t qs_trws16_workspace(const qs_problem *problem, uint64_t iterations)
{
    if (!qs_straight_takes(problem)) {
        return 0;
    }
    state counted = state_of(problem, iterations);
    return take_parts(&counted, NULL);
}

static int32_t heaviest_of(const state *s)
{
    int32_t heaviest = 0;
    for (uint32_t y = 0, p = 0; y < s->height; y++) {
        for (uint32_t x = 0; x < s->width; x++, p++) {
            int32_t right = qs_trws16_right(s, x, p), below = qs_trws16_below(s, y, p);
            heaviest = qs_max_i32(heaviest, qs_max_i32(right, below));
        }
    }
    return heaviest;
}

/* Finds the finest messages for which all sums fit. */
static bool choose_shift(state *s)
{
    uint64_t labels = s->labels, most = UINT8_MAX + WAYS * (uint64_t)heaviest_of(s) * s->reach;
    for (s->shift = 0; s->shift < FINEST && most << (s->shift + 1) < MOST; s->shift++) {
    }
    return most < MOST && labels < MOST;
}

/* The processor can, and the registers and the rounds of the lower envelope are few enough. */
static bool is_wide(const state *s)
{
#if QS_HAVE_AVX2
    return s->pitch <= QS_TRWS16_RUN * QS_TRWS16_RUNS && s->reach <= QS_TRWS16_REACH &&
           qs_lanes_avx2();
#else
    (void)s;
    return false;
#endif
}

/* Scratch has large numbers beside the labels, which the lower envelope may look at. */
static void fill_scratch(const state *s)
{
    for (uint64_t i = 0; i < QS_TRWS16_PARTS * qs_trws16_scratch(s->labels); i++) {
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

/* Costs of sites one after the other, at their pitch. Returns false if one takes more than a
 * byte. */
static bool put_costs(const state *s, const void *costs, unsigned bytes, uint32_t sites,
                      uint8_t *to)
{
    bool fit = true;
    for (uint32_t i = 0; fit && i < sites; i++, to += s->pitch) {
        size_t from = (size_t)i * s->labels;
        if (bytes == 1) {
            memcpy(to, (const uint8_t *)costs + from, s->labels);
        } else {
            fit = put_words(to, (const uint32_t *)costs + from, s->labels);
        }
        memset(to + s->labels, 0, s->pitch - s->labels);
    }
    return fit;
}

/* Those of an array. */
static bool read_array(state *s)
{
    uint8_t *to = s->costs;
    bool fit = true;
    for (qs_strip strip = qs_strip_first(s->problem, s->strip); fit && qs_strip_next(&strip);) {
        fit = put_costs(s, strip.costs, strip.bytes, strip.sites, to);
        for (uint32_t i = 0; i < strip.sites; i++, to += s->pitch) {
            s->first_sum += to[0];
        }
        s->least_sum += strip.least_sum;
    }
    return fit;
}

/* What the parts that read costs have found. */
typedef struct reading {
    const state *s;
    uint32_t parts;
    int64_t least_sum[QS_TRWS16_PARTS], first_sum[QS_TRWS16_PARTS];
    bool fit[QS_TRWS16_PARTS];
} reading;

/* A row of costs that are made, at their place if they can stand there. */
static bool read_row(reading *of, uint32_t part, uint32_t y)
{
    const state *s = of->s;
    const qs_cost_source *source = &s->problem->source;
    char *strip = (char *)s->strip + s->strip_size * part;
    uint8_t *to = s->costs + s->pitch * s->width * y;
    int32_t *least = (void *)strip;
    void *costs = costs_stand(s) ? (void *)to : strip + least_size(s);
    source->row((char *)source->context + source->stride * part, y, costs, least);
    bool fit = costs_stand(s) || put_costs(s, costs, source->bytes, s->width, to);
    for (uint32_t x = 0; x < s->width; x++, to += s->pitch) {
        of->first_sum[part] += to[0];
        of->least_sum[part] += least[x];
    }
    return fit;
}

static void read_rows(void *work, uint32_t part)
{
    reading *of = work;
    uint64_t height = of->s->height;
    uint32_t end = (uint32_t)(height * (part + 1) / of->parts);
    of->least_sum[part] = of->first_sum[part] = 0;
    of->fit[part] = true;
    for (uint32_t y = (uint32_t)(height * part / of->parts); of->fit[part] && y < end; y++) {
        of->fit[part] = read_row(of, part, y);
    }
}

/* Returns false if a cost takes more than a byte. */
static bool read_costs(state *s, const qs_solve_options *options)
{
    reading of = {.s = s, .parts = options && options->together ? readers_of(s) : 1};
    bool fit = true;
    if (s->problem->costs) {
        return read_array(s);
    }
    qs_trws16_together(options, read_rows, &of, of.parts);
    for (uint32_t i = 0; i < of.parts; i++) {
        fit = fit && of.fit[i];
        s->least_sum += of.least_sum[i];
        s->first_sum += of.first_sum[i];
    }
    return fit;
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
                energy += qs_trws16_right(s, x, p) * apart(s, labelling[p], labelling[p + 1]);
            }
            if (y + 1 < s->height) {
                energy +=
                    qs_trws16_below(s, y, p) * apart(s, labelling[p], labelling[p + s->width]);
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
    return (around){s->costs + site * s->pitch,
                    {qs_trws16_left(s, x, site), qs_trws16_right(s, x, site),
                     qs_trws16_above(s, y, site), qs_trws16_below(s, y, site)},
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

static void raise_bound(const state *s, int64_t bound, qs_solution *solution)
{
    int64_t unit = (int64_t)1 << s->shift, whole = bound / unit;
    whole += bound > whole * unit;
    solution->lower_bound = qs_max_i64(solution->lower_bound, whole + s->least_sum);
}

/* A pass forward and one back. Returns false if the watch has stopped them. */
static bool iterate(state *s, const qs_solve_options *options, qs_solution *solution)
{
    for (int way = 0; way < 2; way++) {
        s->is_first = way == 0 && solution->iterations == 0;
        int64_t bound = qs_trws16_pass(s, options, way == 0);
        if (s->look->stopped) {
            return false;
        }
        raise_bound(s, bound, solution);
    }
    solution->iterations++;
    return true;
}

/* The messages of edges that there are not. */
static void clear_ends(const state *s)
{
    size_t row = s->pitch * s->width;
    for (uint32_t y = 0; y < s->row_count; y++) {
        memset(s->rows + (row + s->pitch) * y, 0, sizeof *s->rows * s->pitch);
    }
    memset(s->columns - row, 0, sizeof *s->columns * row);
}

static void solve(state *s, const qs_solve_options *options, uint16_t *labelling,
                  qs_solution *solution)
{
    bool go = true;
    while (go && iterate(s, options, solution)) {
        go = qs_report_progress(options, solution) &&
             !qs_limit_reached(options, solution, DEFAULT_ITERATIONS);
    }
    qs_trws16_label(s, options, labelling);
    improve(s, labelling);
    solution->energy = energy_of(s, labelling);
    solution->converged = solution->energy == solution->lower_bound;
    (void)qs_report_progress(options, solution);
}

qs_status qs_trws16(const qs_problem *problem, const qs_solve_options *options, void *workspace,
                    size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    qs_status status = qs_straight_check(problem, workspace, labelling, solution);
    if (status != QS_OK) {
        return status;
    }
    state s = state_of(problem, options ? options->iterations : 0);
    size_t size = take_parts(&s, workspace);
    if (workspace_size < size || size == SIZE_MAX) {
        return QS_E_WORKSPACE;
    }
    s.wide = is_wide(&s);
    if (s.is_once) {
        s.row_count = qs_min_u32(s.row_count, qs_trws16_flight(&s, options));
    }
    if (!choose_shift(&s) || !read_costs(&s, options)) {
        return QS_E_OVERFLOW;
    }
    fill_scratch(&s);
    memset(labelling, 0, sizeof *labelling * s.sites);
    qs_solution so_far = {.energy = s.least_sum + s.first_sum, .lower_bound = s.least_sum};
    qs_reporter reporter = {options, &so_far};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    s.look = &look;
    clear_ends(&s);
    solve(&s, options, labelling, &so_far);
    *solution = so_far;
    return QS_OK;
}
