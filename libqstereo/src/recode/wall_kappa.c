/* kappa of domain walls for any V (docs/MATHS.md, theorems 7 and 8). */
#include <string.h>

#include "../base/minmax.h"
#include "../model/edge_value.h"
#include "recoder.h"

/* Steps that are spent on exact losses, about a second. After that they are bounded by the largest
 * value of V. */
#define STEPS ((uint64_t)1 << 30)

/* A site of an edge, its neighbour, and the choice: which label a wall stands for that is none. */
typedef struct side {
    const qs_recoder *r;
    uint32_t own, other, edge;
    bool is_first; /* of the edge */
    bool last; /* the labels are counted from the last */
} side;

bool qs_kappa_is_of_values(const qs_pairwise *pairwise)
{
    return pairwise->smoothness != QS_POTTS && pairwise->smoothness != QS_TRUNCATED_LINEAR;
}

static uint32_t label(const side *s, uint32_t site, uint32_t rank)
{
    const qs_remaining *rest = &s->r->rest;
    return rest->label[s->last ? rest->start[site + 1] - 1 - rank : rest->start[site] + rank];
}

/* What the site's own label m costs more than its label p, beside a label of the neighbour. */
static int64_t difference(const side *s, uint32_t m, uint32_t p, uint32_t beside)
{
    const qs_model *model = s->r->rest.model;
    uint32_t x = label(s, s->own, m), y = label(s, s->own, p), b = label(s, s->other, beside);
    return s->is_first ? qs_edge_value(model, s->edge, x, b) - qs_edge_value(model, s->edge, y, b)
                       : qs_edge_value(model, s->edge, b, x) - qs_edge_value(model, s->edge, b, y);
}

/* The most, over the states of the neighbour, of twice the difference at its first candidate, and
 * once the sum of what it rises by from each label that its up-steps take off to the candidate
 * behind. */
static int64_t loss_of(const side *s, uint32_t m, uint32_t p)
{
    const int64_t none = INT64_MIN / 4;
    int64_t at_candidate = none, at_step = none; /* the last label of the state so far */
    for (uint32_t b = 0; b < qs_remaining_size(&s->r->rest, s->other); b++) {
        int64_t f = difference(s, m, p, b),
                candidate = qs_max_i64(2 * f, at_step > none ? at_step + f : none),
                step = at_candidate > none ? at_candidate - f : none;
        at_step = qs_max_i64(at_step, step);
        at_candidate = qs_max_i64(at_candidate, candidate);
    }
    return at_candidate;
}

/* Twice what an up-step of the site can gain at most on the edge, for a weight of 1. */
static int64_t find_loss(const side *s, uint64_t *steps)
{
    const qs_remaining *rest = &s->r->rest;
    uint64_t own = qs_remaining_size(rest, s->own), others = qs_remaining_size(rest, s->other),
             needed = own * own / 2 * others;
    if (own < 3) {
        return 0;
    }
    if (needed > *steps) {
        return 2 * qs_edge_most(rest->model, s->edge) * (int64_t)(1 + (others - 1) / 2);
    }
    *steps -= needed;
    int64_t most = INT64_MIN;
    for (uint32_t m = 1; m < own; m++) {
        for (uint32_t p = m + 1; p < own; p++) {
            most = qs_max_i64(most, loss_of(s, m, p));
        }
    }
    return most;
}

static void add_loss(qs_recoder *r, int64_t *sum, int64_t weight, int64_t loss)
{
    const int64_t most = (int64_t)1 << 61;
    if (weight > 0 && (loss > most / weight || loss < -most / weight)) {
        r->draft.overflow = true;
        return;
    }
    qs_draft_add(&r->draft, sum, weight * loss);
}

static void add_edges(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    const qs_remaining_edge *last = NULL;
    uint64_t steps = STEPS;
    int64_t loss[4] = {0};
    if (!rest->model->tables) {
        qs_order_edges(r);
    }
    for (size_t e = 0; e < rest->counts.edges; e++) {
        const qs_remaining_edge *edge = &rest->edges[rest->model->tables ? e : r->order[e]];
        for (unsigned i = 0; i < 4 && !(last && qs_edges_are_like(r, last, edge)); i++) {
            bool first = i % 2 == 0;
            const side s = {r,
                            first ? edge->first : edge->second,
                            first ? edge->second : edge->first,
                            edge->edge,
                            first,
                            i >= 2};
            loss[i] = find_loss(&s, &steps);
        }
        last = edge;
        add_loss(r, &r->first_choice[edge->first], edge->weight, loss[0]);
        add_loss(r, &r->first_choice[edge->second], edge->weight, loss[1]);
        add_loss(r, &r->last_choice[edge->first], edge->weight, loss[2]);
        add_loss(r, &r->last_choice[edge->second], edge->weight, loss[3]);
    }
}

/* The most that a label, neither the first nor the last, costs more than one behind it. */
static int64_t fall_of_costs(const qs_remaining *rest, uint32_t p, bool last)
{
    uint32_t size = qs_remaining_size(rest, p);
    const int64_t *cost = rest->cost + rest->start[p];
    int64_t highest = INT64_MIN, most = INT64_MIN;
    for (uint32_t i = 1; i < size; i++) {
        int64_t own = cost[last ? size - 1 - i : i];
        most = highest > INT64_MIN ? qs_max_i64(most, highest - own) : most;
        highest = qs_max_i64(highest, own);
    }
    return most;
}

/* kappa less the gap: half of what has been summed up, not below 0. */
static int64_t end_choice(qs_recoder *r, int64_t *choice, bool last)
{
    int64_t total = 0;
    for (uint32_t p = 0; p < r->rest.counts.undecided; p++) {
        if (qs_remaining_size(&r->rest, p) < 3) {
            choice[p] = 0;
            continue;
        }
        qs_draft_add(&r->draft, &choice[p], 2 * fall_of_costs(&r->rest, p, last));
        choice[p] = qs_max_i64(choice[p], 0);
        choice[p] = choice[p] / 2 + choice[p] % 2;
        qs_draft_add(&r->draft, &total, choice[p]);
    }
    return total;
}

/* Returns true if V is the square of the labels' difference, and no site lacks a label between two
 * that it has. */
static bool is_square(const qs_remaining *rest)
{
    const qs_model *m = rest->model;
    uint64_t apart = m->labels - 1u;
    if (m->pairwise.smoothness != QS_TRUNCATED_QUADRATIC ||
        (m->pairwise.truncation != 0 && m->pairwise.truncation < apart * apart)) {
        return false;
    }
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        if (!qs_remaining_is_range(rest, p)) {
            return false;
        }
    }
    return true;
}

/* Theorem 8: a wall stands for as many ones as it has. */
static void find_square_kappa(const qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        int64_t inner = 0;
        for (uint32_t i = rest->start[p] + 1; i + 1 < rest->start[p + 1]; i++) {
            inner = qs_max_i64(inner, rest->cost[i]);
        }
        r->first_choice[p] =
            qs_max_i64(2 * (inner - (int64_t)qs_min_u64(rest->reach[p].weights, INT64_MAX / 4)), 0);
    }
}

void qs_find_kappa(qs_recoder *r)
{
    const qs_remaining *rest = &r->rest;
    /* A block adds up to twice the largest V and more, and a reader moves it up by as much. */
    r->draft.overflow |= rest->model->pairwise_max > INT32_MAX / 4;
    if (is_square(rest)) {
        find_square_kappa(r);
        return;
    }
    memset(r->first_choice, 0, sizeof *r->first_choice * (size_t)rest->counts.undecided);
    memset(r->last_choice, 0, sizeof *r->last_choice * (size_t)rest->counts.undecided);
    add_edges(r);
    int64_t first = end_choice(r, r->first_choice, false),
            last = end_choice(r, r->last_choice, true);
    r->takes_last = last < first;
}

int64_t qs_kappa_of_values(const qs_recoder *r, uint32_t site)
{
    return (r->takes_last ? r->last_choice : r->first_choice)[site] + (int64_t)r->gap;
}
