#include "messages.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/edge_value.h"

/* What the weights of a model come to at one site. */
typedef struct weights {
    int64_t around; /* the largest sum at a site */
    int64_t largest; /* the largest of one edge */
    int64_t all; /* the sum */
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
        all.all += sum;
    }
    all.all /= 2; /* each edge is one of two sites */
    return all;
}

#if QS_BITS == 64

/* The scaled costs of all sites and edges come to no more than 2^QS_MODEL_BITS. What a site has,
 * its messages, and three messages more, are five times that at most. */
bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale)
{
    weights w = weigh(model);
    int64_t all = (int64_t)model->sites * INT32_MAX + w.all * qs_max_i64(model->pairwise_max, 1);
    while (shift > 0 && all > (INT64_C(1) << QS_MODEL_BITS) >> shift) {
        shift--;
    }
    *scale = (qs_scale){shift, w.around * model->pairwise_max + 1};
    return true;
}

bool qs_messages_fit(const qs_model *model, bool sets)
{
    (void)model;
    (void)sets;
    return true;
}

#else

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
static int64_t message_count(const qs_model *model, bool sets)
{
    return (int64_t)most_neighbours(model) + (sets ? 3 : 1);
}

/* What must fit 31 bits beside the unary costs. */
typedef struct demand {
    int64_t edges; /* the most that all edges of a site can cost */
    int64_t messages; /* the largest sum of messages */
    int64_t weight; /* the largest: weights are scaled too, even if their edges cost nothing */
} demand;

/* Returns false if the messages alone do not fit. */
static bool find_demand(const qs_model *model, bool sets, demand *of)
{
    weights w = weigh(model);
    int64_t messages = message_count(model, sets), largest = model->pairwise_max;
    /* So that no product below can overflow. */
    if (largest > 0 && (w.around > INT32_MAX || largest > INT32_MAX ||
                        w.largest * largest > INT32_MAX / messages)) {
        return false;
    }
    of->edges = largest > 0 ? w.around * largest : 0;
    of->messages = messages * w.largest * largest;
    of->weight = w.largest;
    return true;
}

static int64_t most_of(const qs_model *model, bool sets, const demand *of)
{
    int64_t unary = sets ? INT64_MAX : largest_unary(model);
    return qs_min_i64(unary, of->edges + 1);
}

/* The largest number, unscaled. */
static int64_t total_of(const demand *of, int64_t most)
{
    return qs_max_i64(most + of->messages, of->weight);
}

bool qs_messages_fit(const qs_model *model, bool sets)
{
    demand of;
    /* Mostly they do whatever the unary costs are. These are many: they are looked at last. */
    return find_demand(model, sets, &of) && (total_of(&of, of.edges + 1) <= INT32_MAX ||
                                             total_of(&of, most_of(model, sets, &of)) <= INT32_MAX);
}

bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale)
{
    demand of;
    bool sets = model->kept != NULL;
    if (!find_demand(model, sets, &of)) {
        return false;
    }
    int64_t most = most_of(model, sets, &of), total = total_of(&of, most);
    if (total > INT32_MAX) {
        return false;
    }
    while (shift > 0 && total > INT32_MAX >> shift) {
        shift--;
    }
    *scale = (qs_scale){shift, (int32_t)most};
    return true;
}

#endif

enum { NEAR = 4 }; /* a reach up to which all labels within it are looked at */

size_t qs_message_scratch(const qs_model *model)
{
    return model->pairwise.smoothness == QS_TRUNCATED_QUADRATIC ? 2 * (size_t)model->labels : 0;
}

/* message = costs less `least`, and at most `most`. */
static void normalise(qs_number *message, const qs_number *costs, uint32_t labels, qs_number least,
                      qs_number most)
{
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = qs_min_number(costs[d] - least, most);
    }
}

/* V = |a - b|, in two passes (Felzenszwalb and Huttenlocher 2006). */
static void linear(qs_number *costs, uint32_t labels, qs_number weight)
{
    for (uint32_t d = 1; d < labels; d++) {
        costs[d] = qs_min_number(costs[d], costs[d - 1] + weight);
    }
    for (uint32_t d = labels - 1; d > 0; d--) {
        costs[d - 1] = qs_min_number(costs[d - 1], costs[d] + weight);
    }
}

/* The parabola of label a has its lowest point there, and the height costs[a]. Returns the first
 * label, 0 to `labels`, at which the parabola of b is no higher than that of a, where a < b. */
static uint32_t overtakes(const qs_number *costs, uint32_t a, uint32_t b, uint32_t labels,
                          qs_number weight)
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
static void quadratic(const qs_number *costs, qs_number *message, uint32_t labels, qs_number weight,
                      qs_number most, qs_number *scratch)
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
        message[d] = cost < most ? (qs_number)cost : most;
    }
}

/* The largest distance up to which all labels are looked at, as it is small: beyond it all V are
 * truncated. 0 = it is not small. In 64 bits it counts as small wherever V is truncated, for the
 * parabolas go far beyond the truncation. */
static uint32_t reach_of(const qs_model *model)
{
    uint64_t truncation = model->pairwise.truncation, reach = 1;
    uint64_t far = QS_BITS == 64 ? model->labels : NEAR;
    while (reach <= far && (reach + 1) * (reach + 1) <= truncation) {
        reach++;
    }
    return truncation > 0 && reach <= far ? (uint32_t)reach : 0;
}

/* V = min((a - b)^2, truncation): beyond `reach` all cost `most`. */
static void quadratic_near(const qs_number *restrict costs, qs_number *restrict message,
                           uint32_t labels, qs_number weight, qs_number most, uint32_t reach)
{
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = qs_min_number(costs[d], most);
    }
    for (uint32_t apart = 1; apart <= reach && apart < labels; apart++) {
        qs_number cost = weight * (qs_number)(apart * apart);
        for (uint32_t d = 0; d < labels - apart; d++) {
            message[d] = qs_min_number(message[d], costs[d + apart] + cost);
        }
        for (uint32_t d = 0; d < labels - apart; d++) {
            message[d + apart] = qs_min_number(message[d + apart], costs[d] + cost);
        }
    }
}

static void by_table(const int32_t *table, uint32_t labels, qs_number weight, bool upward,
                     const qs_number *costs, qs_number *message)
{
    for (uint32_t a = 0; a < labels; a++) {
        const int32_t *row = table + (size_t)a * labels;
        if (upward) {
            for (uint32_t b = 0; b < labels; b++) {
                qs_number cost = costs[a] + weight * row[b];
                message[b] = a > 0 ? qs_min_number(message[b], cost) : cost;
            }
        } else {
            qs_number least = costs[0] + weight * row[0];
            for (uint32_t b = 1; b < labels; b++) {
                least = qs_min_number(least, costs[b] + weight * row[b]);
            }
            message[a] = least;
        }
    }
}

qs_number qs_message_send(const qs_model *model, uint32_t edge, qs_number weight, bool upward,
                          qs_number *costs, qs_number *message, qs_number *scratch)
{
    uint32_t labels = model->labels, reach;
    qs_number least = qs_least(costs, labels);
    if (weight == 0) {
        memset(message, 0, sizeof *message * labels);
        return least;
    }
    qs_number most = weight * (qs_number)qs_edge_most(model, edge);
    switch (model->pairwise.smoothness) {
    case QS_POTTS: normalise(message, costs, labels, least, most); return least;
    case QS_TRUNCATED_LINEAR:
        linear(costs, labels, weight);
        normalise(message, costs, labels, least, most);
        return least;
    case QS_TRUNCATED_QUADRATIC:
        reach = reach_of(model);
        if (reach > 0) {
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
    least = qs_least(message, labels);
    normalise(message, message, labels, least, most);
    return least;
}

void qs_message_pay(const qs_model *model, uint32_t edge, qs_number weight, bool lower,
                    uint32_t other, qs_number *costs)
{
    if (weight == 0) {
        return;
    }
    for (uint32_t d = 0; d < model->labels; d++) {
        costs[d] += weight * (qs_number)(lower ? qs_edge_value(model, edge, other, d)
                                               : qs_edge_value(model, edge, d, other));
    }
}
