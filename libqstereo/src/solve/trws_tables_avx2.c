/* TRW-S on grids whose costs are tables, eight labels at once. It computes the same as
 * trws_grid.c, to the bit. */
#include "trws_visit.h"

#if QS_HAVE_AVX2

enum { HALF = QS_LANES / 2, AHEAD = 6 };

/* The costs of a site in runs of lanes (simd.h). Fewer labels than lanes are one run, whose last
 * lanes are dead: they are neither read from memory nor written to it. */
typedef struct shape {
    uint32_t labels, runs;
    bool few; /* fewer labels than lanes */
    qs_lanes live; /* of few labels: all bits of the lanes that count */
} shape;

QS_WIDE shape shape_of(uint32_t labels, bool few)
{
    qs_lanes order = {0, 1, 2, 3, 4, 5, 6, 7};
    return (shape){.labels = labels,
                   .runs = few ? 1 : qs_lanes_runs(labels),
                   .few = few,
                   .live = (qs_lanes)(order < (int32_t)labels)};
}

/* What is masked may stand anywhere, although the type of its pointer is that of whole lanes. */
QS_WIDE qs_lanes load(const shape *s, const int32_t *costs, uint32_t run)
{
    return s->few ? (qs_lanes)__builtin_ia32_maskloadd256((const void *)costs, s->live)
                  : qs_lanes_load(costs, run, s->labels);
}

QS_WIDE void store(const shape *s, int32_t *costs, uint32_t run, qs_lanes value)
{
    if (s->few) {
        __builtin_ia32_maskstored256((void *)costs, s->live, value);
    } else {
        qs_lanes_store(costs, run, s->labels, value);
    }
}

/* Dead lanes cost more than any other. */
QS_WIDE qs_lanes bury(const shape *s, qs_lanes costs)
{
    return s->few ? (costs & s->live) | (~s->live & INT32_MAX) : costs;
}

/* The label in a lane of a run; of a dead lane the last label. */
QS_WIDE uint32_t label_in(const shape *s, uint32_t run, uint32_t lane)
{
    if (s->few) {
        return qs_min_u32(lane, s->labels - 1);
    }
    uint32_t wrap = qs_lanes_is_half(run, s->labels) ? HALF - 1 : QS_LANES - 1;
    return qs_lanes_begin(run, s->labels) + (lane & wrap);
}

/* Where the runs have the cost of a label. */
QS_WIDE int32_t cost_of(const shape *s, const qs_loose *costs, uint32_t label)
{
    uint32_t run = s->few ? 0 : label / QS_LANES,
             begin = s->few ? 0 : qs_lanes_begin(run, s->labels);
    return costs[run][label - begin];
}

/* The least of each of eight, in order. */
QS_WIDE qs_lanes least_of_each(const qs_lanes *of)
{
    qs_lanes two[4], four[2];
    for (uint32_t i = 0; i < 4; i++) {
        two[i] = qs_lanes_min(QS_PICK(of[i], of[i + HALF], 0, 1, 2, 3, 8, 9, 10, 11),
                              QS_PICK(of[i], of[i + HALF], 4, 5, 6, 7, 12, 13, 14, 15));
    }
    for (uint32_t i = 0; i < 2; i++) {
        qs_lanes a = two[2 * i], b = two[2 * i + 1];
        four[i] = qs_lanes_min(QS_PICK(a, b, 0, 1, 8, 9, 4, 5, 12, 13),
                               QS_PICK(a, b, 2, 3, 10, 11, 6, 7, 14, 15));
    }
    return qs_lanes_min(QS_PICK(four[0], four[1], 0, 2, 8, 10, 4, 6, 12, 14),
                        QS_PICK(four[0], four[1], 1, 3, 9, 11, 5, 7, 13, 15));
}

/* A run of the message from the site of the table's rows to that of its columns, */
QS_WIDE qs_lanes to_columns(const shape *s, const int32_t *table, int32_t weight,
                            const qs_loose *costs, uint32_t run)
{
    qs_lanes least = qs_lanes_all(INT32_MAX);
    for (uint32_t a = 0; a < s->labels; a++) {
        qs_lanes row = load(s, table + (size_t)a * s->labels, run);
        least = qs_lanes_min(least, row * weight + cost_of(s, costs, a));
    }
    return least;
}

/* and the other way. */
QS_WIDE qs_lanes to_rows(const shape *s, const int32_t *table, int32_t weight,
                         const qs_loose *costs, uint32_t run)
{
    qs_lanes least[QS_LANES];
    for (uint32_t lane = 0; lane < QS_LANES; lane++) {
        const int32_t *row = table + (size_t)label_in(s, run, lane) * s->labels;
        least[lane] = costs[0] + load(s, row, 0) * weight;
        for (uint32_t r = 1; r < s->runs; r++) {
            least[lane] = qs_lanes_min(least[lane], costs[r] + load(s, row, r) * weight);
        }
    }
    return least_of_each(least);
}

QS_WIDE int32_t least_of(const shape *s, const qs_loose *costs)
{
    qs_lanes least = costs[0], none = qs_lanes_all(INT32_MAX);
    for (uint32_t run = 1; run < s->runs; run++) {
        least = qs_lanes_min(least, costs[run]);
    }
    qs_lanes_least(&least, &none);
    return least[0];
}

/* As qs_message_send. */
QS_WIDE int32_t send(const qs_model *model, const shape *s, uint32_t edge, int32_t weight,
                     bool upward, const qs_loose *costs, int32_t *message, qs_loose *rest)
{
    if (weight == 0) {
        memset(message, 0, sizeof *message * s->labels);
        return least_of(s, costs);
    }
    const int32_t *table = qs_edge_table(model, edge);
    for (uint32_t run = 0; run < s->runs; run++) {
        rest[run] = bury(s, upward ? to_columns(s, table, weight, costs, run)
                                   : to_rows(s, table, weight, costs, run));
    }
    int32_t least = least_of(s, rest);
    qs_lanes most = qs_lanes_all(weight * (int32_t)qs_edge_most(model, edge));
    for (uint32_t run = 0; run < s->runs; run++) { /* dead lanes are 0 again: none overflows */
        qs_lanes live = s->few ? (qs_lanes)rest[run] & s->live : (qs_lanes)rest[run];
        store(s, message, run, qs_lanes_min(live - least, most));
    }
    return least;
}

/* Fetches the tables of its own that a site AHEAD sites later will need. */
QS_WIDE void fetch(const qs_model *model, uint32_t site, bool forward)
{
    uint32_t ahead = forward ? site + AHEAD : site - AHEAD;
    if (model->tables && ahead > model->width && ahead < model->sites) {
        uint32_t row = forward ? ahead : ahead - 1, column = forward ? ahead : ahead - model->width;
        uint32_t numbers = model->labels * model->labels;
        qs_lanes_fetch(qs_edge_table(model, qs_cell_edge(row, false)), numbers);
        qs_lanes_fetch(qs_edge_table(model, qs_cell_edge(column, true)), numbers);
    }
}

QS_WIDE int64_t pass(const qs_trws_state *state, const shape *s, bool forward)
{
    const qs_model *model = state->model;
    qs_loose *row = (qs_loose *)state->scratch, *column = row + s->runs, *rest = column + s->runs;
    qs_lanes most = qs_lanes_all(state->scale.most);
    int64_t bound = 0;
    for (uint32_t at = 0; at < qs_trws_visits(state) && qs_trws_going(state, at); at++) {
        uint32_t p = qs_trws_site(state, at, forward);
        qs_visit v = qs_visit_of(state, p, s->labels, forward);
        qs_lanes share = qs_lanes_all(v.row_share);
        fetch(model, p, forward);
        for (uint32_t run = 0; run < s->runs; run++) {
            qs_lanes row_back = load(s, v.row_out, run), column_back = load(s, v.column_out, run);
            qs_lanes total = qs_lanes_min(load(s, model->unary + v.first, run), most)
                             << (int)state->scale.shift;
            total =
                total + row_back + column_back + load(s, v.row_in, run) + load(s, v.column_in, run);
            qs_lanes part = total >> (int)v.halves & share;
            row[run] = bury(s, part - row_back);
            column[run] = bury(s, total - part - column_back);
        }
        bound += send(model, s, v.row_edge, v.row_weight, forward, row, v.row_out, rest);
        bound +=
            send(model, s, v.column_edge, v.column_weight, forward, column, v.column_out, rest);
    }
    return bound;
}

/* Few labels have code of their own, which keeps the costs in registers. */
QS_AVX2 static int64_t few_labels(const qs_trws_state *state, bool forward)
{
    shape s = shape_of(state->model->labels, true);
    return forward ? pass(state, &s, true) : pass(state, &s, false);
}

QS_AVX2 static int64_t many_labels(const qs_trws_state *state, bool forward)
{
    shape s = shape_of(state->model->labels, false);
    return forward ? pass(state, &s, true) : pass(state, &s, false);
}

int64_t qs_trws_wide_tables_pass(const qs_trws_state *state, bool forward)
{
    return state->model->labels < QS_LANES ? few_labels(state, forward)
                                           : many_labels(state, forward);
}

#endif
