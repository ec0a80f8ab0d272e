/* TRW-S on grids with Potts costs, eight labels at once. It computes the same as trws_grid.c, to
 * the bit. */
#include "trws_visit.h"

#if QS_HAVE_AVX2

enum { AHEAD = 8 };

/* Fetches what the site AHEAD sites later will need. */
QS_WIDE void fetch(const qs_trws_state *state, uint32_t at, uint32_t labels, bool forward)
{
    uint32_t ahead = forward ? at + AHEAD : at - AHEAD;
    if (ahead < state->model->sites) {
        qs_lanes_fetch(state->messages + 2 * (size_t)labels * ahead, 2 * labels);
        qs_lanes_fetch(state->model->unary + (size_t)labels * ahead, labels);
    }
}

/* One site. All labels of a message are read before any is written, so that a run of lanes may do
 * some labels twice. */
QS_WIDE int64_t site(const qs_trws_state *state, uint32_t at, uint32_t labels, bool forward,
                     qs_loose *row, qs_loose *column)
{
    qs_visit v = qs_visit_of(state, at, labels, forward);
    fetch(state, at, labels, forward);
    qs_lanes most = qs_lanes_all(state->scale.most), share = qs_lanes_all(v.row_share),
             row_least = most, column_least = most;
    uint32_t runs = qs_lanes_runs(labels);
    for (uint32_t run = 0; run < runs; run++) {
        qs_lanes row_back = qs_lanes_load(v.row_out, run, labels),
                 column_back = qs_lanes_load(v.column_out, run, labels);
        qs_lanes total =
            qs_lanes_min(qs_lanes_load(state->model->unary + v.first, run, labels), most)
            << (int)state->scale.shift;
        total = total + row_back + column_back + qs_lanes_load(v.column_in, run, labels) +
                qs_lanes_load(v.row_in, run, labels);
        qs_lanes part = total >> (int)v.halves & share;
        qs_lanes row_cost = part - row_back, column_cost = total - part - column_back;
        row_least = run > 0 ? qs_lanes_min(row_least, row_cost) : row_cost;
        column_least = run > 0 ? qs_lanes_min(column_least, column_cost) : column_cost;
        row[run] = row_cost;
        column[run] = column_cost;
    }
    qs_lanes_least(&row_least, &column_least);
    qs_lanes row_weight = qs_lanes_all(v.row_weight), column_weight = qs_lanes_all(v.column_weight);
    for (uint32_t run = 0; run < runs; run++) {
        qs_lanes_store(v.row_out, run, labels, qs_lanes_min(row[run] - row_least, row_weight));
        qs_lanes_store(v.column_out, run, labels,
                       qs_lanes_min(column[run] - column_least, column_weight));
    }
    return (int64_t)row_least[0] + column_least[0];
}

/* Two rows at once, the second one a site behind the first. Along a row each site waits for the one
 * before it; the two rows do not wait for each other. */
QS_WIDE int64_t two_rows(const qs_trws_state *state, uint32_t labels, bool forward, uint32_t first,
                         uint32_t second, qs_loose *row, qs_loose *column)
{
    int64_t bound = site(state, first, labels, forward, row, column);
    for (uint32_t x = 1; x < state->model->width; x++) {
        first = forward ? first + 1 : first - 1;
        bound += site(state, first, labels, forward, row, column);
        bound += site(state, second, labels, forward, row, column);
        second = forward ? second + 1 : second - 1;
    }
    return bound + site(state, second, labels, forward, row, column);
}

QS_WIDE int64_t pass(const qs_trws_state *state, uint32_t labels, bool forward, qs_loose *row,
                     qs_loose *column)
{
    const qs_model *model = state->model;
    uint32_t width = model->width, y = 0, last = model->sites - 1;
    int64_t bound = 0;
    if (state->visits) {
        for (uint32_t at = 0; at < state->visit_count && qs_trws_going(state, at); at++) {
            bound += site(state, qs_trws_site(state, at, forward), labels, forward, row, column);
        }
        return bound;
    }
    uint64_t work = 2 * (uint64_t)width * labels;
    for (; y + 1 < model->height && qs_look_up(state->look, work); y += 2) {
        uint32_t first = y * width, second = first + width;
        bound += two_rows(state, labels, forward, forward ? first : last - first,
                          forward ? second : last - second, row, column);
    }
    for (uint32_t at = y * width; at < model->sites; at++) {
        bound += site(state, forward ? at : last - at, labels, forward, row, column);
    }
    return bound;
}

/* For the numbers of labels of the common benchmarks there is code of its own, which keeps the
 * costs in registers. */
QS_WIDE int64_t any_labels(const qs_trws_state *state, bool forward)
{
    enum { TSUKUBA = 16, VENUS = 20, RUNS = 3 };
    qs_loose row[RUNS], column[RUNS];
    uint32_t labels = state->model->labels, runs = qs_lanes_runs(labels);
    switch (labels) {
    case TSUKUBA: return pass(state, TSUKUBA, forward, row, column);
    case VENUS: return pass(state, VENUS, forward, row, column);
    default:
        return pass(state, labels, forward, (qs_loose *)state->scratch,
                    (qs_loose *)state->scratch + runs);
    }
}

QS_AVX2 static int64_t forward_pass(const qs_trws_state *state)
{
    return any_labels(state, true);
}

QS_AVX2 static int64_t backward_pass(const qs_trws_state *state)
{
    return any_labels(state, false);
}

int64_t qs_trws_wide_pass(const qs_trws_state *state, bool forward)
{
    return forward ? forward_pass(state) : backward_pass(state);
}

#endif
