#include "../../include/qstereo/solve.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/random.h"
#include "../model/neighbours.h"
#include "progress.h"

/* Logarithms and temperatures are fixed-point numbers, so that the answer is the same on every
 * machine. */
enum {
    ONE = 1 << 16, /* 1 as a logarithm */
    SWEEPS = 1000,
    COOLEST = 8, /* the last temperature is this part of the first one */
    FINE = 2 * COOLEST /* logarithms are of FINE times the temperature: none is below 0 */
};

/* How much log2(1 + x) is above x: 0.3431 x (1 - x), to within 0.009. */
static uint32_t bend(uint32_t x)
{
    return (uint32_t)((uint64_t)22485 * x / ONE * (ONE - x) / ONE);
}

/* The logarithm to base 2 of n, n >= 1. */
static uint32_t log2_of(uint64_t n)
{
    uint32_t whole = 0;
    while (n >> whole > 1) {
        whole++;
    }
    uint32_t x = (uint32_t)((whole >= 16 ? n >> (whole - 16) : n << (16 - whole)) & (ONE - 1));
    return whole * ONE + x + bend(x);
}

/* The reverse, in units of 1/256. l is below 40. */
static uint64_t exp2_of(uint32_t l)
{
    uint32_t x = l % ONE;
    return (uint64_t)(ONE + x - bend(x)) << l / ONE >> 8;
}

/* The largest rise of the energy that Metropolis' rule accepts with the random number u:
 *
 *     rise <= -T ln((u + 1) / 2^32)
 *
 * temperature  T, in units of 1/256 */
static int64_t accepted_rise(uint64_t temperature, uint32_t u)
{
    uint64_t minus_log2 = 32u * ONE - log2_of((uint64_t)u + 1);
    uint64_t minus_ln = minus_log2 * 45426 / ONE;
    return (int64_t)(temperature * minus_ln >> 24);
}

/* A sweep at one temperature: every site in turn is offered a label. */
static void sweep(const qs_model *model, uint64_t temperature, qs_look *look, uint64_t *random,
                  uint16_t *labelling, qs_solution *s)
{
    enum { DRAW_WORK = 32, EDGE_WORK = 8 }; /* in numbers computed */
    for (uint32_t p = 0; p < model->sites; p++) {
        if (!qs_look_up(look, DRAW_WORK + EDGE_WORK * (uint64_t)qs_edges_at(model, p))) {
            return;
        }
        uint64_t number = qs_draw(random);
        uint16_t label = (uint16_t)((number >> 32) * model->labels >> 32);
        if (label == labelling[p]) {
            continue;
        }
        int64_t rise = qs_label_cost(model, labelling, p, label) -
                       qs_label_cost(model, labelling, p, labelling[p]);
        if (rise <= 0 || rise <= accepted_rise(temperature, (uint32_t)number)) {
            labelling[p] = label;
            s->energy += rise;
        }
    }
}

/* The largest cost of an edge, at least 1: about what it takes to move a site against its
 * neighbours. */
static uint64_t largest_edge(const qs_model *model)
{
    int32_t weight = 1;
    if (model->width > 0) {
        for (uint32_t p = 0; p < model->sites; p++) {
            weight = qs_max_i32(weight, qs_max_i32(model->right[p], model->down[p]));
        }
    } else {
        for (uint32_t n = 0; n < model->link_start[model->sites]; n++) {
            weight = qs_max_i32(weight, model->links[n].weight);
        }
    }
    uint64_t cost = (uint64_t)weight * (uint64_t)qs_max_i64(model->pairwise_max, 1);
    return qs_min_u64(cost, INT32_MAX);
}

/* The logarithm of FINE times the temperature when `done` of ONE is done. From half the largest
 * cost of an edge, where labels of a Potts model begin to hold together, down to a COOLEST-th of
 * that, where nothing moves any more. */
static uint32_t cooled(uint32_t hottest, uint64_t done)
{
    return hottest - (uint32_t)(log2_of(COOLEST) * done / ONE);
}

/* How much of the sweeps is done, of ONE; ONE in the last one. Where the time is limited, a part of
 * it is left for icm.
 *
 * sweeps  0 = no limit */
static uint64_t done_of(const qs_solve_options *options, uint64_t sweep_number, uint64_t sweeps)
{
    enum { LEFT_PART = 16 };
    uint64_t done = sweeps == 1 ? ONE : sweeps == 0 ? 0 : sweep_number * ONE / (sweeps - 1);
    if (options && options->spent) {
        uint64_t spent = options->spent(options->context);
        done = qs_max_u64(done, (spent + spent / LEFT_PART) * ONE / QS_ALL_TIME);
    }
    return qs_min_u64(done, ONE);
}

/* All sweeps. Returns false if the watch has stopped it. */
static bool cool(const qs_model *model, const qs_solve_options *options, uint16_t *labelling,
                 qs_solution *s)
{
    uint64_t random = options ? options->seed : 0, sweeps = options && options->iterations > 0
                                                                ? options->iterations
                                                            : options && options->spent ? 0
                                                                                        : SWEEPS;
    uint32_t hottest = log2_of(largest_edge(model) * FINE / 2);
    qs_reporter reporter = {options, s};
    qs_look look = {.going = qs_report_now, .context = &reporter};
    uint64_t done = 0;
    bool go = true;
    while (go && done < ONE) {
        done = done_of(options, s->iterations, sweeps);
        sweep(model, exp2_of(cooled(hottest, done)) / FINE, &look, &random, labelling, s);
        go = !look.stopped && qs_report_progress(options, s);
        s->iterations += !look.stopped;
    }
    return go;
}

/* Ends with icm. If the watch has stopped the sweeps it does one sweep, which nobody waits long
 * for. */
static qs_status descend(const qs_model *model, const qs_solve_options *options, bool go,
                         uint16_t *labelling, qs_solution *s)
{
    qs_solution descent;
    qs_solve_options own = {.iterations = go ? 0 : 1};
    if (go && options) {
        own.watch = options->watch;
        own.context = options->context;
    }
    qs_status status = qs_icm(model, &own, NULL, 0, labelling, &descent);
    s->energy = descent.energy;
    s->converged = go && descent.converged;
    return status;
}

size_t qs_anneal_workspace(const qs_model *model)
{
    return sizeof(uint16_t) * model->sites;
}

qs_status qs_anneal(const qs_model *model, const qs_solve_options *options, void *workspace,
                    size_t workspace_size, uint16_t *labelling, qs_solution *solution)
{
    if (!model || !workspace || !labelling || !solution || !qs_labels_in_range(model, labelling)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_anneal_workspace(model)) {
        return QS_E_WORKSPACE;
    }
    uint16_t *start = workspace;
    memcpy(start, labelling, sizeof *start * model->sites);
    int64_t start_energy = qs_model_energy(model, labelling);
    qs_solution s = {.energy = start_energy, .lower_bound = QS_NO_BOUND};
    bool go = cool(model, options, labelling, &s);
    qs_status status = descend(model, options, go, labelling, &s);
    if (s.energy > start_energy) {
        memcpy(labelling, start, sizeof *start * model->sites);
        s.energy = start_energy;
    }
    s.energy -= qs_take_kept_everywhere(model, labelling);
    *solution = s;
    return status;
}
