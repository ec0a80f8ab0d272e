#include "messages.h"

#include <string.h>

#include "../base/simd.h"

/* The largest sum of the weights at one site, and the largest weight. */
static void weigh(const qs_model *model, int64_t *around, int64_t *largest)
{
    *around = *largest = 0;
    for (uint32_t p = 0; p < model->sites; p++) {
        int64_t sum = 0, weight = 0;
        if (model->width > 0) {
            sum = (int64_t)model->right[p] + model->down[p] + (p > 0 ? model->right[p - 1] : 0) +
                  (p >= model->width ? model->down[p - model->width] : 0);
            weight = model->right[p] > model->down[p] ? model->right[p] : model->down[p];
        } else {
            for (uint32_t n = model->link_start[p]; n < model->link_start[p + 1]; n++) {
                sum += model->links[n].weight;
                weight = model->links[n].weight > weight ? model->links[n].weight : weight;
            }
        }
        *around = sum > *around ? sum : *around;
        *largest = weight > *largest ? weight : *largest;
    }
}

static int64_t largest_unary(const qs_model *model)
{
    int32_t largest = 0;
    for (size_t i = 0; i < (size_t)model->sites * model->labels; i++) {
        largest = model->unary[i] > largest ? model->unary[i] : largest;
    }
    return largest;
}

static int64_t most_neighbours(const qs_model *model)
{
    enum { GRID = 4 };
    uint32_t most = 0;
    for (uint32_t p = 0; model->width == 0 && p < model->sites; p++) {
        uint32_t links = model->link_start[p + 1] - model->link_start[p];
        most = links > most ? links : most;
    }
    return model->width > 0 ? GRID : most;
}

bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale)
{
    int64_t around, weight, unary = largest_unary(model),
                            messages = most_neighbours(model) + (model->kept ? 3 : 1),
                            largest = model->pairwise_max;
    weigh(model, &around, &weight);
    /* So that no product below can overflow. */
    if (largest > 0 &&
        (around > INT32_MAX || largest > INT32_MAX || weight * largest > INT32_MAX / messages)) {
        return false;
    }
    int64_t edges = largest > 0 ? around * largest : 0;
    int64_t most = unary <= edges && !model->kept ? unary : edges + 1;
    int64_t total = most + messages * weight * largest;
    total = weight > total
                ? weight
                : total; /* weights are scaled too, even those of edges that cost nothing */
    if (total > INT32_MAX) {
        return false;
    }
    while (shift > 0 && total > INT32_MAX >> shift) {
        shift--;
    }
    *scale = (qs_scale){shift, (int32_t)most};
    return true;
}

size_t qs_message_scratch(const qs_model *model)
{
    return model->pairwise.smoothness == QS_TRUNCATED_QUADRATIC ? 2 * (size_t)model->labels : 0;
}

static int32_t least_of(const int32_t *costs, uint32_t labels)
{
    int32_t least = costs[0];
    for (uint32_t d = 1; d < labels; d++) {
        least = qs_min32(least, costs[d]);
    }
    return least;
}

/* Everything less `least`, and at most `most`. */
static void normalise(int32_t *message, const int32_t *costs, uint32_t labels, int32_t least,
                      int32_t most)
{
    for (uint32_t d = 0; d < labels; d++) {
        message[d] = qs_min32(costs[d] - least, most);
    }
}

/* Two passes (Felzenszwalb and Huttenlocher 2006). */
static void linear(int32_t *costs, uint32_t labels, int32_t weight)
{
    for (uint32_t d = 1; d < labels; d++) {
        costs[d] = qs_min32(costs[d], costs[d - 1] + weight);
    }
    for (uint32_t d = labels - 1; d > 0; d--) {
        costs[d - 1] = qs_min32(costs[d - 1], costs[d] + weight);
    }
}

/* The first whole label from 0 to `labels` at which the parabola of `b` is no higher than that of a
 * < b. */
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

/* Lower envelope of parabolas (the same), each from the first whole label where it is the lowest:
 * exact on whole labels. */
static void quadratic(const int32_t *costs, int32_t *message, uint32_t labels, int32_t weight,
                      int32_t most, int32_t *scratch)
{
    uint32_t *lowest = (uint32_t *)scratch, *from = lowest + labels, count = 0;
    for (uint32_t d = 0; d < labels; d++) {
        uint32_t begin = 0;
        while (count > 0 && (begin = overtakes(costs, lowest[count - 1], d, labels, weight)) <=
                                from[count - 1]) {
            count--;
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

static void by_table(const qs_model *model, int32_t weight, bool upward, const int32_t *costs,
                     int32_t *message)
{
    uint32_t labels = model->labels;
    for (uint32_t a = 0; a < labels; a++) {
        const int32_t *row = model->pairwise.table + (size_t)a * labels;
        if (upward) {
            for (uint32_t b = 0; b < labels; b++) {
                int32_t cost = costs[a] + weight * row[b];
                message[b] = a > 0 ? qs_min32(message[b], cost) : cost;
            }
        } else {
            int32_t least = costs[0] + weight * row[0];
            for (uint32_t b = 1; b < labels; b++) {
                least = qs_min32(least, costs[b] + weight * row[b]);
            }
            message[a] = least;
        }
    }
}

int32_t qs_message_send(const qs_model *model, int32_t weight, bool upward, int32_t *costs,
                        int32_t *message, int32_t *scratch)
{
    uint32_t labels = model->labels;
    int32_t least = least_of(costs, labels);
    if (weight == 0) {
        memset(message, 0, sizeof *message * labels);
        return least;
    }
    int32_t most = weight * (int32_t)model->pairwise_max;
    switch (model->pairwise.smoothness) {
    case QS_POTTS: normalise(message, costs, labels, least, most); return least;
    case QS_TRUNCATED_LINEAR:
        linear(costs, labels, weight);
        normalise(message, costs, labels, least, most);
        return least;
    case QS_TRUNCATED_QUADRATIC:
        quadratic(costs, message, labels, weight, least + most, scratch);
        normalise(message, message, labels, least, most);
        return least;
    case QS_TABLE: break;
    }
    by_table(model, weight, upward, costs, message);
    least = least_of(message, labels);
    normalise(message, message, labels, least, most);
    return least;
}

void qs_message_pay(const qs_model *model, int32_t weight, bool lower, uint32_t other,
                    int32_t *costs)
{
    for (uint32_t d = 0; weight != 0 && d < model->labels; d++) {
        costs[d] += weight * (int32_t)(lower ? qs_model_pairwise(model, other, d)
                                             : qs_model_pairwise(model, d, other));
    }
}
