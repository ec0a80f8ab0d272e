/* Belief propagation on grids with Potts costs, eight labels at once. It computes the same as
 * bp_grid.c, to the bit. */
#include "bp_visit.h"

#if QS_HAVE_AVX2

enum { AHEAD = 8 };

QS_WIDE qs_lanes sum_of(const qs_bp_state *state, const qs_letter *letter, uint32_t run,
                        uint32_t labels)
{
    qs_lanes unary = qs_lanes_min(qs_lanes_load(state->model->unary + letter->first, run, labels),
                                  qs_lanes_all(state->scale.most))
                     << (int)state->scale.shift;
    return unary + qs_lanes_load(letter->beside[0], run, labels) +
           qs_lanes_load(letter->beside[1], run, labels) +
           qs_lanes_load(letter->behind, run, labels);
}

/* The costs that a message is made of, and the message before. */
typedef struct draft {
    qs_loose *costs, *before;
} draft;

/* Reads all of the old message before any of the new one is written: a run of lanes may do some
 * labels twice, and must not take a new number for an old one. */
QS_WIDE qs_lanes begin(const qs_bp_state *state, const qs_letter *letter, uint32_t labels,
                       uint32_t run, qs_lanes least, draft at)
{
    qs_lanes sum = sum_of(state, letter, run, labels);
    at.costs[run] = sum;
    at.before[run] = qs_lanes_load(letter->message, run, labels);
    return qs_lanes_min(least, sum);
}

QS_WIDE void finish(const qs_letter *letter, uint32_t labels, uint32_t run, qs_lanes least,
                    draft at)
{
    qs_lanes message = qs_lanes_min(at.costs[run] - least, qs_lanes_all(letter->weight)),
             apart = (at.before[run] - message) * QS_KEEP;
    qs_lanes kept = (apart + (apart >> 31 & ((1 << QS_KEEP_OF) - 1))) >>
                    QS_KEEP_OF; /* towards 0, as C divides */
    qs_lanes_store(letter->message, run, labels, message + kept);
}

QS_WIDE void send_two(const qs_bp_state *state, qs_letter one, qs_letter two, uint32_t labels,
                      draft at_one, draft at_two)
{
    qs_lanes least_one = qs_lanes_all(INT32_MAX), least_two = least_one;
    for (uint32_t run = 0; run < qs_lanes_runs(labels); run++) {
        least_one = begin(state, &one, labels, run, least_one, at_one);
        least_two = begin(state, &two, labels, run, least_two, at_two);
    }
    qs_lanes_least(&least_one, &least_two);
    for (uint32_t run = 0; run < qs_lanes_runs(labels); run++) {
        finish(&one, labels, run, least_one, at_one);
        finish(&two, labels, run, least_two, at_two);
    }
}

/* Fetches what the messages of a site are made of, AHEAD sites before its turn. Does nothing past
 * either end. */
QS_WIDE void fetch(const qs_bp_state *state, uint32_t site, uint32_t labels)
{
    if (site < state->model->sites) {
        qs_lanes_fetch(state->messages + (size_t)QS_FROM_ALL * labels * site, QS_FROM_ALL * labels);
        qs_lanes_fetch(state->model->unary + (size_t)labels * site, labels);
    }
}

/* The sweeps to the right and to the left do not use each other's messages. So they go at the same
 * time, from both ends of a row. */
QS_WIDE void along_row(const qs_bp_state *state, uint32_t first, uint32_t labels, draft one,
                       draft two)
{
    uint32_t width = state->model->width, last = first + width - 1;
    for (uint32_t x = 0; x + 1 < width; x++) {
        fetch(state, first + x + AHEAD, labels);
        fetch(state, last - x - AHEAD, labels);
        send_two(state, qs_letter_of(state, first + x, labels, QS_FROM_LEFT),
                 qs_letter_of(state, last - x, labels, QS_FROM_RIGHT), labels, one, two);
    }
}

/* Sends from all cells of a row to the next row, or to the one before. The last cell of an odd
 * number is done twice, which does not change the result. */
QS_WIDE void across(const qs_bp_state *state, uint32_t first, int from, uint32_t labels, draft one,
                    draft two)
{
    uint32_t end = first + state->model->width;
    for (uint32_t p = first; p < end; p += 2) {
        uint32_t q = p + 1 < end ? p + 1 : p;
        fetch(state, p + AHEAD, labels);
        fetch(state, q + AHEAD, labels);
        send_two(state, qs_letter_of(state, p, labels, from), qs_letter_of(state, q, labels, from),
                 labels, one, two);
    }
}

/* The sweep down follows the sweeps along the rows one row behind, while the messages are in the
 * cache. It changes none that those still need. */
QS_WIDE void sweep(const qs_bp_state *state, uint32_t labels, draft one, draft two)
{
    uint32_t width = state->model->width, sites = state->model->sites;
    uint64_t work = 3 * (uint64_t)width * labels;
    for (uint32_t first = 0; first < sites && qs_look_up(state->look, work); first += width) {
        along_row(state, first, labels, one, two);
        if (first > 0) {
            across(state, first - width, QS_FROM_ABOVE, labels, one, two);
        }
    }
    for (uint32_t first = sites - width; first > 0 && qs_look_up(state->look, work / 3);
         first -= width) {
        across(state, first, QS_FROM_BELOW, labels, one, two);
    }
}

/* For the numbers of labels of the common benchmarks there is code of its own, which keeps the
 * costs in registers. */
enum { TSUKUBA = 16, VENUS = 20, RUNS = 3 };

QS_AVX2 static void sweep_any(const qs_bp_state *state)
{
    qs_loose memory[4][RUNS], *scratch = (qs_loose *)state->scratch;
    uint32_t labels = state->model->labels, runs = qs_lanes_runs(labels);
    draft one = {memory[0], memory[1]}, two = {memory[2], memory[3]};
    switch (labels) {
    case TSUKUBA: sweep(state, TSUKUBA, one, two); break;
    case VENUS: sweep(state, VENUS, one, two); break;
    default:
        sweep(state, labels, (draft){scratch, scratch + runs},
              (draft){scratch + 2 * runs, scratch + 3 * runs});
        break;
    }
}

void qs_bp_wide_sweep(const qs_bp_state *state)
{
    sweep_any(state);
}

#endif
