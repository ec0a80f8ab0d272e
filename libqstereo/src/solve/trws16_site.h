/* What a pass of TRW-S computes at one site, in numbers of 16 bits that a compiler makes vectors
 * of. */
#ifndef QS_TRWS16_SITE_H
#define QS_TRWS16_SITE_H

#include "../base/simd.h"

enum { QS_TRWS16_ROWS = 3, QS_TRWS16_MOST = 1 << 14 };

typedef struct qs_trws16_rule {
    uint32_t labels;
    uint32_t reach; /* V(a, b) = min(|a - b|, reach) */
    int16_t unit; /* messages are in units of 1 / unit */
    bool is_first; /* no message has come back yet: they count as 0 */
    int16_t *scratch; /* QS_TRWS16_ROWS of qs_trws16_row numbers */
} qs_trws16_rule;

typedef struct qs_trws16_visit {
    const uint8_t *costs;
    const int16_t *row_in, *column_in;
    int16_t *row_out, *column_out;
    int16_t row_weight, column_weight; /* of the edges that messages are sent along, shifted */
    int16_t row_share; /* all bits 1: the row takes a part; 0: the column takes all */
    bool both; /* each takes a half */
    bool row_only; /* column_out is neither read nor written */
    int16_t *sums; /* out: costs and the messages that come in; may be column_in. NULL = unwanted */
} qs_trws16_visit;

/* Numbers in a row of scratch: the labels, and as many at both ends. */
static inline uint64_t qs_trws16_row(uint32_t labels)
{
    enum { LEAST = 16 }; /* one run of the wide registers */
    return 3 * (uint64_t)labels + LEAST;
}

/* Numbers of scratch for one thread. */
static inline uint64_t qs_trws16_scratch(uint32_t labels)
{
    return QS_TRWS16_ROWS * qs_trws16_row(labels);
}

QS_KERNEL int16_t qs_less16(int16_t a, int16_t b)
{
    return a < b ? a : b;
}

/* One round of the lower envelope: to[d] = min(from[d], from[d +- step] + step * weight). */
QS_KERNEL void qs_trws16_spread(const int16_t *restrict from, uint32_t labels, uint32_t step,
                                int16_t weight, int16_t *restrict to)
{
    int16_t more = (int16_t)((int32_t)step * weight);
    const int16_t *before = from - step, *after = from + step;
    for (uint32_t d = 0; d < labels; d++) {
        int16_t other = (int16_t)(qs_less16(before[d], after[d]) + more);
        to[d] = qs_less16(from[d], other);
    }
}

/* Minimises costs over an edge: message[d] = min over e of costs[e] + weight V(e, d), less the
 * least cost, which is returned. Distances up to 1, 3, 7 and so on take a round each: rounds of
 * steps 1, 2, 4 together reach as far as their sum. From reach on the cap does the same.
 *
 * costs, other  rows of scratch, at their labels; costs is overwritten */
QS_KERNEL int16_t qs_trws16_send(const qs_trws16_rule *rule, int16_t weight, int16_t *costs,
                                 int16_t *other, int16_t *restrict message)
{
    uint32_t labels = rule->labels;
    int16_t least = costs[0], cap = (int16_t)(weight * (int32_t)rule->reach);
    for (uint32_t d = 0; d < labels; d++) {
        least = qs_less16(least, costs[d]);
    }
    for (uint32_t d = 0; d < labels; d++) {
        costs[d] = qs_less16((int16_t)(costs[d] - least), cap);
    }
    uint32_t done = 0;
    for (uint32_t step = 1; done + 1 < rule->reach; step *= 2) {
        step = step < rule->reach - 1 - done ? step : rule->reach - 1 - done;
        qs_trws16_spread(costs, labels, step, weight, other);
        int16_t *turned = costs;
        costs = other;
        other = turned;
        done += step;
    }
    memcpy(message, costs, sizeof *message * labels);
    return least;
}

/* What each label costs on the two chains of a site as they go on from here. The flags are
 * constants where this is called. */
QS_KERNEL void qs_trws16_charge(const qs_trws16_rule *rule, const qs_trws16_visit *v, bool is_first,
                                bool both, int16_t *restrict row, int16_t *restrict column)
{
    const uint8_t *costs = v->costs;
    const int16_t *row_in = v->row_in, *column_in = v->column_in, *row_out = v->row_out,
                  *column_out = v->column_out;
    int16_t unit = rule->unit, share = v->row_share;
    for (uint32_t d = 0, labels = rule->labels; d < labels; d++) {
        int16_t back = is_first ? 0 : row_out[d], over = is_first ? 0 : column_out[d];
        int16_t total = (int16_t)(costs[d] * unit + row_in[d] + column_in[d] + back + over);
        int16_t part = both ? (int16_t)(total >> 1) : (int16_t)(total & share);
        row[d] = (int16_t)(part - back);
        column[d] = (int16_t)(total - part - over);
    }
}

/* Keeps what the labelling needs of the messages. */
QS_KERNEL void qs_trws16_keep(const qs_trws16_rule *rule, const qs_trws16_visit *v)
{
    for (uint32_t d = 0; v->sums && d < rule->labels; d++) {
        v->sums[d] = (int16_t)(v->costs[d] * rule->unit + v->row_in[d] + v->column_in[d]);
    }
}

/* Sends the messages of a site to its later neighbours. Returns what that adds to the bound. */
QS_KERNEL int64_t qs_trws16_visit_site(const qs_trws16_rule *rule, const qs_trws16_visit *v)
{
    size_t each = (size_t)qs_trws16_row(rule->labels);
    int16_t *row = rule->scratch + rule->labels, *column = row + each, *other = column + each;
    if (rule->is_first) {
        if (v->both) {
            qs_trws16_charge(rule, v, true, true, row, column);
        } else {
            qs_trws16_charge(rule, v, true, false, row, column);
        }
    } else if (v->both) {
        qs_trws16_charge(rule, v, false, true, row, column);
    } else {
        qs_trws16_charge(rule, v, false, false, row, column);
    }
    qs_trws16_keep(rule, v);
    int64_t bound = qs_trws16_send(rule, v->row_weight, row, other, v->row_out);
    return v->row_only
               ? bound
               : bound + qs_trws16_send(rule, v->column_weight, column, other, v->column_out);
}

/* The labels of the neighbours that messages would be sent to, with the weights of the edges. */
typedef struct qs_trws16_beside {
    uint16_t row, column;
    int16_t row_weight, column_weight;
} qs_trws16_beside;

/* The first of the cheapest labels of a site. */
QS_KERNEL uint16_t qs_trws16_cheapest(const qs_trws16_rule *rule, const int16_t *sums,
                                      const qs_trws16_beside *near)
{
    uint32_t labels = rule->labels, first = 0;
    int16_t *restrict costs = rule->scratch + labels;
    int16_t reach = (int16_t)rule->reach, least = INT16_MAX;
    for (uint32_t d = 0; d < labels; d++) {
        int16_t off = (int16_t)((int16_t)d - (int16_t)near->row),
                over = (int16_t)((int16_t)d - (int16_t)near->column);
        off = qs_less16((int16_t)(off < 0 ? -off : off), reach);
        over = qs_less16((int16_t)(over < 0 ? -over : over), reach);
        costs[d] = (int16_t)(sums[d] + off * near->row_weight + over * near->column_weight);
    }
    for (uint32_t d = 0; d < labels; d++) {
        least = qs_less16(least, costs[d]);
    }
    while (costs[first] != least) {
        first++;
    }
    return (uint16_t)first;
}

#endif
