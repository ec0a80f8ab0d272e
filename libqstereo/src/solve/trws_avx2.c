/* TRW-S on grids with Potts costs and linear ones, eight labels at once. It computes the same as
 * trws_grid.c, to the bit.
 *
 * V(a, b) = min(|a - b|, reach), of Potts costs with reach 1. A message is the least of the costs
 * from all labels, each with what the distance costs; no cost is above `weight` times reach. Up to
 * the reach NEAR a few steps there and back, of 1, 2 and 4, which together reach as far as their
 * sum, are quickest; else a sweep each way. To go further than reach does no harm: it costs at
 * least as much as the cap. */
#include "trws_visit.h"

#if QS_HAVE_AVX2

enum { AHEAD = 8, NEAR = 8 };

/* Fetches what the site AHEAD sites later will need. */
QS_WIDE void fetch(const qs_trws_state *state, uint32_t at, uint32_t labels, bool forward)
{
    uint32_t ahead = forward ? at + AHEAD : at - AHEAD;
    if (ahead < state->model->sites) {
        qs_lanes_fetch(state->messages + 2 * (size_t)labels * ahead, 2 * labels);
        qs_lanes_fetch(state->model->unary + (size_t)labels * ahead, labels);
    }
}

/* Where the labels of the last run lie, which is not whole (simd.h). To be moved along, they have
 * to lie in order, with dead lanes behind them. */
typedef struct ending {
    uint32_t runs;
    bool whole, half;
    qs_lanes live; /* all bits of the lanes that hold labels when they are in order */
    qs_lanes ahead, back; /* the lanes to take from, to put the run in order and back */
    qs_lanes old; /* all bits of the lanes that the run before fills, when it is put back */
} ending;

QS_WIDE ending ending_of(uint32_t labels)
{
    qs_lanes order = {0, 1, 2, 3, 4, 5, 6, 7};
    int32_t rest = (int32_t)(labels % QS_LANES);
    return (ending){.runs = qs_lanes_runs(labels),
                    .whole = rest == 0,
                    .half = rest == QS_LANES / 2,
                    .live = (qs_lanes)(order < rest),
                    .ahead = (order + QS_LANES - rest) & (QS_LANES - 1),
                    .back = (order + rest) & (QS_LANES - 1),
                    .old = (qs_lanes)(order < QS_LANES - rest)};
}

QS_WIDE qs_lanes permuted(qs_lanes a, qs_lanes from)
{
    return (qs_lanes)__builtin_ia32_permvarsi256(a, from);
}

/* The last run in order; its dead lanes cost `most`. */
QS_WIDE qs_lanes put_in_order(const ending *e, qs_lanes last, qs_lanes most)
{
    qs_lanes ordered = e->half ? last : permuted(last, e->ahead);
    return (ordered & e->live) | (most & ~e->live);
}

/* The other way round; `before` = the run before it. */
QS_WIDE qs_lanes put_back(const ending *e, qs_lanes before, qs_lanes last)
{
    return e->half ? last
                   : (permuted(before, e->back) & e->old) | (permuted(last, e->back) & ~e->old);
}

/* `here`, or what comes from `step` labels before it or after it. */
QS_WIDE qs_lanes step_to(qs_lanes before, qs_lanes here, qs_lanes after, uint32_t step,
                         qs_lanes more)
{
    qs_lanes up, down;
    switch (step) {
    case 1:
        up = QS_PICK(before, here, 7, 8, 9, 10, 11, 12, 13, 14);
        down = QS_PICK(here, after, 1, 2, 3, 4, 5, 6, 7, 8);
        break;
    case 2:
        up = QS_PICK(before, here, 6, 7, 8, 9, 10, 11, 12, 13);
        down = QS_PICK(here, after, 2, 3, 4, 5, 6, 7, 8, 9);
        break;
    default:
        up = QS_PICK(before, here, 4, 5, 6, 7, 8, 9, 10, 11);
        down = QS_PICK(here, after, 4, 5, 6, 7, 8, 9, 10, 11);
        break;
    }
    return qs_lanes_min(here, qs_lanes_min(up, down) + more);
}

/* One step of 1, 2 or 4 labels there and back. Beside the labels all cost `most`. */
QS_WIDE void step_around(qs_loose *costs, uint32_t runs, uint32_t step, qs_lanes weight,
                         qs_lanes most)
{
    qs_lanes before = most, here = costs[0], more = weight * (int32_t)step;
    for (uint32_t run = 0; run < runs; run++) {
        qs_lanes after = most;
        if (run + 1 < runs) {
            after = costs[run + 1];
        }
        costs[run] = step_to(before, here, after, step, more);
        before = here;
        here = after;
    }
}

/* From the first label to the last, however far: within each run by steps of 1, 2 and 4, and from
 * the last label of the run before. */
QS_WIDE void sweep_up(qs_loose *costs, uint32_t runs, qs_lanes weight, qs_lanes most)
{
    qs_lanes end = {7, 7, 7, 7, 7, 7, 7, 7}, far = {1, 2, 3, 4, 5, 6, 7, 8}, before = most;
    far *= weight;
    for (uint32_t run = 0; run < runs; run++) {
        qs_lanes here = costs[run];
        here = qs_lanes_min(here, QS_PICK(most, here, 7, 8, 9, 10, 11, 12, 13, 14) + weight);
        here = qs_lanes_min(here, QS_PICK(most, here, 6, 7, 8, 9, 10, 11, 12, 13) + 2 * weight);
        here = qs_lanes_min(here, QS_PICK(most, here, 4, 5, 6, 7, 8, 9, 10, 11) + 4 * weight);
        before = qs_lanes_min(here, permuted(before, end) + far);
        costs[run] = before;
    }
}

/* The same from the last label to the first. */
QS_WIDE void sweep_down(qs_loose *costs, uint32_t runs, qs_lanes weight, qs_lanes most)
{
    qs_lanes end = {0}, far = {8, 7, 6, 5, 4, 3, 2, 1}, after = most;
    far *= weight;
    for (uint32_t run = runs; run-- > 0;) {
        qs_lanes here = costs[run];
        here = qs_lanes_min(here, QS_PICK(here, most, 1, 2, 3, 4, 5, 6, 7, 8) + weight);
        here = qs_lanes_min(here, QS_PICK(here, most, 2, 3, 4, 5, 6, 7, 8, 9) + 2 * weight);
        here = qs_lanes_min(here, QS_PICK(here, most, 4, 5, 6, 7, 8, 9, 10, 11) + 4 * weight);
        after = qs_lanes_min(here, permuted(after, end) + far);
        costs[run] = after;
    }
}

/* Costs that are less their least, and at most `weight` times `reach`, become a message. */
QS_AVX2 static void spread(const ending *e, qs_loose *costs, int32_t weight, uint32_t reach)
{
    qs_lanes all = qs_lanes_all(weight), most = qs_lanes_all(weight * (int32_t)reach);
    uint32_t last = e->runs - 1;
    if (!e->whole) {
        costs[last] = put_in_order(e, costs[last], most);
    }
    if (reach > NEAR) {
        sweep_up(costs, e->runs, all, most);
        sweep_down(costs, e->runs, all, most);
    } else {
        step_around(costs, e->runs, 1, all, most);
        if (reach > 2) {
            step_around(costs, e->runs, 2, all, most);
        }
        if (reach > 4) {
            step_around(costs, e->runs, 4, all, most);
        }
    }
    if (!e->whole) { /* so there is a run before the last one */
        costs[last] = put_back(e, costs[last - 1], costs[last]);
    }
}

/* What is the same at all sites of a pass. */
typedef struct rule {
    uint32_t labels, reach;
    bool forward;
    ending end;
    qs_loose *row, *column; /* the costs of a site */
} rule;

/* The costs of a site on its chains.
 *
 * row_least, column_least  out: the least of them, in all lanes */
QS_WIDE void charge(const qs_trws_state *state, const rule *r, const qs_visit *v,
                    qs_lanes *row_least, qs_lanes *column_least)
{
    uint32_t labels = r->labels;
    qs_lanes most = qs_lanes_all(state->scale.most), share = qs_lanes_all(v->row_share), row = most,
             column = most;
    for (uint32_t run = 0; run < r->end.runs; run++) {
        qs_lanes row_back = qs_lanes_load(v->row_out, run, labels),
                 column_back = qs_lanes_load(v->column_out, run, labels);
        qs_lanes total =
            qs_lanes_min(qs_lanes_load(state->model->unary + v->first, run, labels), most)
            << (int)state->scale.shift;
        total = total + row_back + column_back + qs_lanes_load(v->column_in, run, labels) +
                qs_lanes_load(v->row_in, run, labels);
        qs_lanes part = total >> (int)v->halves & share;
        qs_lanes row_cost = part - row_back, column_cost = total - part - column_back;
        row = run > 0 ? qs_lanes_min(row, row_cost) : row_cost;
        column = run > 0 ? qs_lanes_min(column, column_cost) : column_cost;
        r->row[run] = row_cost;
        r->column[run] = column_cost;
    }
    qs_lanes_least(&row, &column);
    *row_least = row;
    *column_least = column;
}

/* Sends costs to a later site. All labels of a message are read before any is written, so that a
 * run of lanes may do some labels twice. */
QS_WIDE void send(const rule *r, qs_loose *costs, qs_lanes least, int32_t weight, int32_t *message)
{
    qs_lanes most = qs_lanes_all(weight * (int32_t)r->reach);
    if (r->reach > 1) {
        for (uint32_t run = 0; run < r->end.runs; run++) {
            costs[run] = qs_lanes_min(costs[run] - least, most);
        }
        spread(&r->end, costs, weight, r->reach);
        least = qs_lanes_all(0);
    }
    for (uint32_t run = 0; run < r->end.runs; run++) {
        qs_lanes_store(message, run, r->labels, qs_lanes_min(costs[run] - least, most));
    }
}

/* One site. Returns what its messages add to the bound. */
QS_WIDE int64_t site(const qs_trws_state *state, const rule *r, uint32_t at)
{
    qs_visit v = qs_visit_of(state, at, r->labels, r->forward);
    qs_lanes row_least, column_least;
    fetch(state, at, r->labels, r->forward);
    charge(state, r, &v, &row_least, &column_least);
    send(r, r->row, row_least, v.row_weight, v.row_out);
    send(r, r->column, column_least, v.column_weight, v.column_out);
    return (int64_t)row_least[0] + column_least[0];
}

/* Two rows at once, the second one a site behind the first. Along a row each site waits for the one
 * before it; the two rows do not wait for each other. */
QS_WIDE int64_t two_rows(const qs_trws_state *state, const rule *r, uint32_t first, uint32_t second)
{
    int64_t bound = site(state, r, first);
    for (uint32_t x = 1; x < state->model->width; x++) {
        first = r->forward ? first + 1 : first - 1;
        bound += site(state, r, first);
        bound += site(state, r, second);
        second = r->forward ? second + 1 : second - 1;
    }
    return bound + site(state, r, second);
}

QS_WIDE int64_t pass(const qs_trws_state *state, uint32_t labels, uint32_t reach, bool forward,
                     qs_loose *row, qs_loose *column)
{
    const rule r = {labels, reach, forward, ending_of(labels), row, column};
    const qs_model *model = state->model;
    uint32_t width = model->width, y = 0, last = model->sites - 1;
    int64_t bound = 0;
    if (state->visits) {
        for (uint32_t at = 0; at < state->visit_count && qs_trws_going(state, at); at++) {
            bound += site(state, &r, qs_trws_site(state, at, forward));
        }
        return bound;
    }
    uint64_t work = 2 * (uint64_t)width * labels;
    for (; y + 1 < model->height && qs_look_up(state->look, work); y += 2) {
        uint32_t first = y * width, second = first + width;
        bound +=
            two_rows(state, &r, forward ? first : last - first, forward ? second : last - second);
    }
    for (uint32_t at = y * width; at < model->sites; at++) {
        bound += site(state, &r, forward ? at : last - at);
    }
    return bound;
}

QS_WIDE int64_t any_labels(const qs_trws_state *state, uint32_t reach, bool forward)
{
    uint32_t labels = state->model->labels;
    qs_loose *row = (qs_loose *)state->scratch;
    return pass(state, labels, reach, forward, row, row + qs_lanes_runs(labels));
}

/* For the numbers of labels of the common benchmarks there is code of its own, which keeps the
 * costs in registers. */
QS_WIDE int64_t common_labels(const qs_trws_state *state, bool forward)
{
    enum { TSUKUBA = 16, VENUS = 20, RUNS = 3 };
    qs_loose row[RUNS], column[RUNS];
    switch (state->model->labels) {
    case TSUKUBA: return pass(state, TSUKUBA, 1, forward, row, column);
    case VENUS: return pass(state, VENUS, 1, forward, row, column);
    default: return any_labels(state, 1, forward);
    }
}

QS_AVX2 static int64_t potts_pass(const qs_trws_state *state, bool forward)
{
    return forward ? common_labels(state, true) : common_labels(state, false);
}

QS_AVX2 static int64_t linear_pass(const qs_trws_state *state, bool forward)
{
    return any_labels(state, (uint32_t)state->model->pairwise_max, forward);
}

int64_t qs_trws_wide_pass(const qs_trws_state *state, bool forward)
{
    return state->model->pairwise.smoothness == QS_POTTS ? potts_pass(state, forward)
                                                         : linear_pass(state, forward);
}

#endif
