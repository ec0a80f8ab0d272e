#include "messages.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/edge_value.h"

/* What the weights of a model come to at one site. */
typedef struct weights {
    int64_t around; /* the largest sum at a site */
    int64_t largest; /* the largest of one edge */
} weights;

static void weigh_cell(const qs_model *model, uint32_t p, int64_t *sum, int64_t *largest)
{
    int64_t right = model->right[p], down = model->down[p];
    *sum = right + down + (p > 0 ? model->right[p - 1] : 0) +
           (p >= model->width ? model->down[p - model->width] : 0);
    *largest = qs_max_i64(right, down); /* the other two are looked at where they begin */
}

static void weigh_vertex(const qs_model *model, uint32_t p, int64_t *sum, int64_t *largest)
{
    *sum = *largest = 0;
    for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
        *sum += model->links[n].weight;
        *largest = qs_max_i64(*largest, model->links[n].weight);
    }
}

static weights weigh(const qs_model *model)
{
    weights all = {0};
    for (uint32_t p = 0; p < model->sites; p++) {
        int64_t sum, largest;
        if (model->width > 0) {
            weigh_cell(model, p, &sum, &largest);
        } else {
            weigh_vertex(model, p, &sum, &largest);
        }
        all.around = qs_max_i64(all.around, sum);
        all.largest = qs_max_i64(all.largest, largest);
    }
    return all;
}

static int32_t largest_unary(const qs_model *model)
{
    int32_t largest = 0;
    for (size_t i = 0; i < (size_t)model->sites * model->labels; i++) {
        largest = qs_max_i32(largest, model->unary[i]);
    }
    return largest;
}

static uint32_t most_neighbours(const qs_model *model)
{
    enum { GRID = 4 };
    if (model->width > 0) {
        return GRID;
    }
    uint32_t most = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        most = qs_max_u32(most, model->link_start[p + 1] - model->link_start[p]);
    }
    return most;
}

/* Messages whose sum must fit: one from each neighbour and the one to be sent, and two more of the
 * marginals. */
static int64_t message_count(const qs_model *model)
{
    return (int64_t)most_neighbours(model) + (model->kept ? 3 : 1);
}

bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale)
{
    weights w = weigh(model);
    int64_t unary = largest_unary(model), messages = message_count(model),
            largest = model->pairwise_max;
    /* So that no product below can overflow. */
    if (largest > 0 && (w.around > INT32_MAX || largest > INT32_MAX ||
                        w.largest * largest > INT32_MAX / messages)) {
        return false;
    }
    int64_t edges = largest > 0 ? w.around * largest : 0;
    int64_t most = unary <= edges && !model->kept ? unary : edges + 1;
    int64_t total = most + messages * w.largest * largest;
    total =
        qs_max_i64(total, w.largest); /* weights are scaled too, even if their edges cost nothing */
    if (total > INT32_MAX) {
        return false;
    }
    while (shift > 0 && total > INT32_MAX >> shift) {
        shift--;
    }
    *scale = (qs_scale){shift, (int32_t)most};
    return true;
}

enum { NEAR = 4 }; /* a reach up to which all labels within it are looked at */

size_t qs_message_scratch(const qs_model *model)
{
    return model->pairwise.smoothness == QS_TRUNCATED_QUADRATIC ? 2 * (size_t)model->labels : 0;
}

static int32_t least_of(const int32_t *costs, uint32_t labels)
{
    int32_t least = costs[0];
    for (uint32_t d = 1; d < labels; d++) {
        least = qs_min_i32(least, costs[d]);
    }
    return least;
}

/* message = costs less `least`, and at most `most`. */
static void normalise(int32_t *message, const int32_t *costs, uint32_t labels, int32_t least,
                      int32_t most)
{
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = qs_min_i32(costs[d] - least, most);
    }
}

/* V = |a - b|, in two passes (Felzenszwalb and Huttenlocher 2006). */
static void linear(int32_t *costs, uint32_t labels, int32_t weight)
{
    for (uint32_t d = 1; d < labels; d++) {
        costs[d] = qs_min_i32(costs[d], costs[d - 1] + weight);
    }
    for (uint32_t d = labels - 1; d > 0; d--) {
        costs[d - 1] = qs_min_i32(costs[d - 1], costs[d] + weight);
    }
}

/* The parabola of label a has its lowest point there, and the height costs[a]. Returns the first
 * label, 0 to `labels`, at which the parabola of b is no higher than that of a, where a < b. */
static uint32_t overtakes(const int32_t *costs, uint32_t a, uint32_t b, uint32_t labels,
                          int32_t weight)
{
    int64_t rise = (int64_t)costs[b] - costs[a] + weight * ((int64_t)b * b - (int64_t)a * a);
    int64_t slope = 2 * (int64_t)weight * (b - a);
    if (rise <= 0) {
        return 0;
    }
    int64_t first = (rise + slope - 1) / slope;
    return first < labels ? (uint32_t)first : labels;
}

/* V = (a - b)^2, by the lower envelope of the labels' parabolas (the same paper). Each parabola of
 * the envelope is noted with the first label at which it is the lowest, so it is exact. */
static void quadratic(const int32_t *costs, int32_t *message, uint32_t labels, int32_t weight,
                      int32_t most, int32_t *scratch)
{
    uint32_t *lowest = (uint32_t *)scratch, *from = lowest + labels, count = 0;
    for (uint32_t d = 0; d < labels; d++) {
        uint32_t begin = 0;
        while (count > 0) {
            begin = overtakes(costs, lowest[count - 1], d, labels, weight);
            if (begin > from[count - 1]) {
                break;
            }
            count--; /* that one is the lowest nowhere any more */
        }
        if (count == 0 || begin < labels) {
            from[count] = count > 0 ? begin : 0;
            lowest[count++] = d;
        }
    }
    for (uint32_t d = 0, at = 0; d < labels; d++) {
        while (at + 1 < count && from[at + 1] <= d) {
            at++;
        }
        int64_t apart = (int64_t)d - lowest[at], cost = costs[lowest[at]] + weight * apart * apart;
        message[d] = cost < most ? (int32_t)cost : most;
    }
}

/* The largest distance at which V = (a - b)^2 is below or at its truncation, or `far` if that is
 * larger. */
static uint32_t reach_of(uint32_t truncation, uint32_t far)
{
    uint32_t reach = 1;
    while (reach <= far && (reach + 1) * (reach + 1) <= truncation) {
        reach++;
    }
    return reach;
}

/* V = min((a - b)^2, truncation) of a small truncation: beyond `reach` all cost `most`. */
static void quadratic_near(const int32_t *restrict costs, int32_t *restrict message,
                           uint32_t labels, int32_t weight, int32_t most, uint32_t reach)
{
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = qs_min_i32(costs[d], most);
    }
    for (uint32_t apart = 1; apart <= reach && apart < labels; apart++) {
        int32_t cost = weight * (int32_t)(apart * apart);
        for (uint32_t d = 0; d < labels - apart; d++) {
            message[d] = qs_min_i32(message[d], costs[d + apart] + cost);
        }
        for (uint32_t d = 0; d < labels - apart; d++) {
            message[d + apart] = qs_min_i32(message[d + apart], costs[d] + cost);
        }
    }
}

static void by_table(const int32_t *table, uint32_t labels, int32_t weight, bool upward,
                     const int32_t *costs, int32_t *message)
{
    for (uint32_t a = 0; a < labels; a++) {
        const int32_t *row = table + (size_t)a * labels;
        if (upward) {
            for (uint32_t b = 0; b < labels; b++) {
                int32_t cost = costs[a] + weight * row[b];
                message[b] = a > 0 ? qs_min_i32(message[b], cost) : cost;
            }
        } else {
            int32_t least = costs[0] + weight * row[0];
            for (uint32_t b = 1; b < labels; b++) {
                least = qs_min_i32(least, costs[b] + weight * row[b]);
            }
            message[a] = least;
        }
    }
}

int32_t qs_message_send(const qs_model *model, uint32_t edge, int32_t weight, bool upward,
                        int32_t *costs, int32_t *message, int32_t *scratch)
{
    uint32_t labels = model->labels, truncation, reach;
    int32_t least = least_of(costs, labels);
    if (weight == 0) {
        memset(message, 0, sizeof *message * labels);
        return least;
    }
    int32_t most = weight * (int32_t)qs_edge_most(model, edge);
    switch (model->pairwise.smoothness) {
    case QS_POTTS: normalise(message, costs, labels, least, most); return least;
    case QS_TRUNCATED_LINEAR:
        linear(costs, labels, weight);
        normalise(message, costs, labels, least, most);
        return least;
    case QS_TRUNCATED_QUADRATIC:
        truncation = model->pairwise.truncation;
        reach = truncation > 0 ? reach_of(truncation, NEAR) : NEAR + 1;
        if (reach <= NEAR) {
            quadratic_near(costs, message, labels, weight, least + most, reach);
        } else {
            quadratic(costs, message, labels, weight, least + most, scratch);
        }
        normalise(message, message, labels, least, most);
        return least;
    case QS_TABLE:
    case QS_TABLES: break;
    }
    by_table(qs_edge_table(model, edge), labels, weight, upward, costs, message);
    least = least_of(message, labels);
    normalise(message, message, labels, least, most);
    return least;
}

void qs_message_pay(const qs_model *model, uint32_t edge, int32_t weight, bool lower,
                    uint32_t other, int32_t *costs)
{
    if (weight == 0) {
        return;
    }
    for (uint32_t d = 0; d < model->labels; d++) {
        costs[d] += weight * (int32_t)(lower ? qs_edge_value(model, edge, other, d)
                                             : qs_edge_value(model, edge, d, other));
    }
}
