#include "remaining.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../model/edge_value.h"
#include "../qubo/sites.h"

/* ---- The model's sites and edges. ---- */

static bool has(const qs_model *model, const uint8_t *kept, uint32_t site, uint32_t label)
{
    return !kept || kept[(size_t)site * model->labels + label] != 0;
}

static uint32_t labels_left(const qs_model *model, const uint8_t *kept, uint32_t site)
{
    if (!kept) {
        return model->labels;
    }
    uint32_t count = 0;
    for (uint32_t d = 0; d < model->labels; d++) {
        count += has(model, kept, site, d);
    }
    return count;
}

/* Walks the edges in the order of the file: right neighbours, then lower ones; of a graph each
 * site's later neighbours. Zero but for the model = before the first. */
typedef struct edge_cursor {
    const qs_model *model;
    uint32_t site, link;
    bool down;
    qs_remaining_edge edge; /* of the model's sites */
} edge_cursor;

/* Moves on by a cell; returns true if there is an edge at the one before. */
static bool grid_edge(edge_cursor *at)
{
    const qs_model *m = at->model;
    uint32_t p = at->site++, q = p + (at->down ? m->width : 1);
    bool inside = at->down ? q < m->sites : q % m->width != 0;
    if (!inside || qs_is_masked(m->mask, p) || qs_is_masked(m->mask, q)) {
        return false;
    }
    int32_t weight = at->down ? m->down[p] : m->right[p];
    at->edge = (qs_remaining_edge){p, q, weight, qs_cell_edge(p, at->down)};
    return true;
}

static bool next_grid_edge(edge_cursor *at)
{
    for (;;) {
        if (at->site == at->model->sites) {
            if (at->down) {
                return false;
            }
            at->down = true;
            at->site = 0;
        } else if (grid_edge(at)) {
            return true;
        }
    }
}

static bool next_link(edge_cursor *at)
{
    const qs_model *m = at->model;
    while (at->site < m->sites) {
        if (at->link == m->link_start[at->site + 1]) {
            at->site++;
            continue;
        }
        const qs_link *link = &m->links[at->link++];
        if (link->site > at->site) {
            at->edge = (qs_remaining_edge){at->site, link->site, link->weight, link->edge};
            return true;
        }
    }
    return false;
}

static bool next_edge(edge_cursor *at)
{
    return at->model->width > 0 ? next_grid_edge(at) : next_link(at);
}

/* ---- Counting. ---- */

/* Looks whether labels have been left out anywhere. */
static void count_labels(const qs_model *model, const uint8_t *kept, qs_remaining_counts *c)
{
    c->whole = true;
    for (uint32_t p = 0; p < model->sites; p++) {
        if (!qs_is_masked(model->mask, p)) {
            uint32_t count = labels_left(model, kept, p);
            c->sites++;
            c->whole &= count == model->labels;
            c->empty |= count == 0;
        }
    }
}

qs_remaining_counts qs_remaining_count(const qs_model *model, const uint8_t *kept,
                                       bool one_is_enough)
{
    qs_remaining_counts c = {0};
    count_labels(model, kept, &c);
    uint32_t least = c.whole && one_is_enough ? 1 : 2;
    for (uint32_t p = 0; p < model->sites; p++) {
        uint32_t count = qs_is_masked(model->mask, p) ? 0 : labels_left(model, kept, p);
        if (count >= least) {
            c.undecided++;
            c.labels += count;
        }
    }
    for (edge_cursor at = {.model = model}; next_edge(&at);) {
        uint32_t first = labels_left(model, kept, at.edge.first),
                 second = labels_left(model, kept, at.edge.second);
        if (first >= least && second >= least) {
            c.edges++;
            c.thresholds += qs_min_u64((uint64_t)first + second + 1, (uint64_t)model->labels + 1);
        }
    }
    return c;
}

/* ---- Workspace. ---- */

qs_remaining qs_remaining_take(qs_arena *arena, const qs_model *model,
                               const qs_remaining_counts *counts, bool truncate)
{
    const uint64_t sites = counts->undecided, labels = counts->labels;
    qs_smoothness smoothness = model->pairwise.smoothness;
    qs_remaining rest = {.model = model, .counts = *counts, .constant = model->constant};
    rest.cost = qs_arena_take(arena, labels, sizeof *rest.cost);
    rest.label = qs_arena_take(arena, labels, sizeof *rest.label);
    rest.start = qs_arena_take(arena, sites + 1, sizeof *rest.start);
    rest.reach = qs_arena_take(arena, sites, sizeof *rest.reach);
    rest.cell = qs_arena_take(arena, sites, sizeof *rest.cell);
    rest.edges = qs_arena_take(arena, counts->edges, sizeof *rest.edges);
    rest.number = qs_arena_take(arena, model->sites, sizeof *rest.number);
    rest.fixed = qs_arena_take(arena, model->sites, sizeof *rest.fixed);
    if (truncate) {
        rest.trimmed = qs_arena_take(arena, labels, sizeof *rest.trimmed);
    }
    if (smoothness != QS_POTTS) {
        rest.label_reach = qs_arena_take(arena, labels, sizeof *rest.label_reach);
    }
    if (smoothness == QS_TABLE) {
        rest.row_max = qs_arena_take(arena, model->labels, sizeof *rest.row_max);
        rest.column_max = qs_arena_take(arena, model->labels, sizeof *rest.column_max);
    }
    return rest;
}

/* ---- Folding. ---- */

static void fix_site(qs_remaining *rest, const uint8_t *kept, uint32_t p)
{
    const qs_model *m = rest->model;
    uint32_t d = 0;
    while (!has(m, kept, p, d)) {
        d++;
    }
    rest->fixed[p] = (uint16_t)d;
    qs_add(&rest->constant, m->unary[(size_t)p * m->labels + d], &rest->overflow);
}

/* Copies the labels left and their costs to `at` and behind; returns the place behind them. */
static uint32_t enter_labels(qs_remaining *rest, const uint8_t *kept, uint32_t p, uint32_t at)
{
    const qs_model *m = rest->model;
    for (uint32_t d = 0; d < m->labels; d++) {
        if (has(m, kept, p, d)) {
            rest->label[at] = (uint16_t)d;
            rest->cost[at++] = m->unary[(size_t)p * m->labels + d];
        }
    }
    return at;
}

static void enter_sites(qs_remaining *rest, const uint8_t *kept)
{
    const qs_model *m = rest->model;
    /* Then sites of one label are undecided too, if there are any. */
    bool all_undecided = rest->counts.undecided == rest->counts.sites;
    uint32_t number = 0, at = 0;
    for (uint32_t p = 0; p < m->sites; p++) {
        rest->number[p] = QS_NO_SITE;
        if (qs_is_masked(m->mask, p)) {
            continue;
        }
        if (!all_undecided && labels_left(m, kept, p) == 1) {
            fix_site(rest, kept, p);
            continue;
        }
        rest->number[p] = (int32_t)number;
        rest->cell[number] = p;
        rest->start[number++] = at;
        at = enter_labels(rest, kept, p, at);
    }
    rest->start[number] = at;
}

/* Adds to each label of an undecided site what the edge to a fixed neighbour costs it. */
static void fold(qs_remaining *rest, const qs_remaining_edge *edge, bool first_is_undecided)
{
    const qs_model *m = rest->model;
    uint32_t p = first_is_undecided ? edge->first : edge->second,
             other = rest->fixed[first_is_undecided ? edge->second : edge->first];
    uint32_t site = (uint32_t)rest->number[p];
    for (uint32_t i = rest->start[site]; i < rest->start[site + 1]; i++) {
        uint32_t d = rest->label[i];
        int64_t cost = first_is_undecided ? qs_edge_value(m, edge->edge, d, other)
                                          : qs_edge_value(m, edge->edge, other, d);
        qs_add(&rest->cost[i], edge->weight * cost, &rest->overflow);
    }
}

static void enter_edges(qs_remaining *rest)
{
    const qs_model *m = rest->model;
    uint64_t count = 0;
    for (edge_cursor at = {.model = m}; next_edge(&at);) {
        const qs_remaining_edge *edge = &at.edge;
        int32_t first = rest->number[edge->first], second = rest->number[edge->second];
        if (edge->weight == 0 && !rest->counts.whole) {
            continue;
        }
        if (first != QS_NO_SITE && second != QS_NO_SITE) {
            rest->edges[count++] =
                (qs_remaining_edge){(uint32_t)first, (uint32_t)second, edge->weight, edge->edge};
        } else if (first != QS_NO_SITE || second != QS_NO_SITE) {
            fold(rest, edge, first != QS_NO_SITE);
        } else {
            int64_t cost =
                qs_edge_value(m, edge->edge, rest->fixed[edge->first], rest->fixed[edge->second]);
            qs_add(&rest->constant, edge->weight * cost, &rest->overflow);
        }
    }
    rest->counts.edges = count;
}

/* Subtracts from each site its least cost. */
static void shift(qs_remaining *rest)
{
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        int64_t least = INT64_MAX;
        for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
            least = qs_min_i64(least, rest->cost[i]);
        }
        for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
            rest->cost[i] -= least;
            rest->overflow |= rest->cost[i] > QS_ENERGY_MAX;
            rest->no_model |= rest->cost[i] > INT32_MAX;
        }
        qs_add(&rest->constant, least, &rest->overflow);
    }
}

/* ---- What the edges can cost. ---- */

static void find_maxima(const qs_remaining *rest)
{
    const qs_model *m = rest->model;
    memset(rest->row_max, 0, sizeof *rest->row_max * m->labels);
    memset(rest->column_max, 0, sizeof *rest->column_max * m->labels);
    for (uint32_t a = 0; a < m->labels; a++) {
        for (uint32_t b = 0; b < m->labels; b++) {
            int64_t cost = qs_model_pairwise(m, a, b);
            rest->row_max[a] = qs_max_i64(rest->row_max[a], cost);
            rest->column_max[b] = qs_max_i64(rest->column_max[b], cost);
        }
    }
}

/* The largest V of an edge for a label beside the labels left to another undecided site. The label
 * is V's first argument or its second. */
static int64_t largest_cost(const qs_remaining *rest, uint32_t edge, uint32_t label, uint32_t other,
                            bool is_first)
{
    const qs_model *m = rest->model;
    const uint16_t *labels = rest->label + rest->start[other];
    uint32_t count = qs_remaining_size(rest, other);
    if (m->pairwise.smoothness < QS_TABLE) {
        /* V rises with the distance. */
        return qs_max_i64(qs_model_pairwise(m, label, labels[0]),
                          qs_model_pairwise(m, label, labels[count - 1]));
    }
    if (rest->row_max && count == m->labels) {
        return is_first ? rest->row_max[label] : rest->column_max[label];
    }
    int64_t largest = 0;
    for (uint32_t i = 0; i < count; i++) {
        int64_t cost = is_first ? qs_edge_value(m, edge, label, labels[i])
                                : qs_edge_value(m, edge, labels[i], label);
        largest = qs_max_i64(largest, cost);
    }
    return largest;
}

/* Adds to each label of the first or second site of an edge what the edge can cost it. */
static void reach_along(const qs_remaining *rest, const qs_remaining_edge *edge, bool is_first)
{
    uint32_t p = is_first ? edge->first : edge->second, q = is_first ? edge->second : edge->first;
    for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
        int64_t cost = largest_cost(rest, edge->edge, rest->label[i], q, is_first);
        qs_grow(&rest->label_reach[i], (uint64_t)edge->weight, (uint64_t)cost);
    }
}

static void reach_labels(const qs_remaining *rest)
{
    memset(rest->label_reach, 0, sizeof *rest->label_reach * (size_t)rest->counts.labels);
    if (rest->row_max) {
        find_maxima(rest);
    }
    for (uint64_t e = 0; e < rest->counts.edges; e++) {
        const qs_remaining_edge *edge = &rest->edges[e];
        reach_along(rest, edge, true);
        reach_along(rest, edge, false);
    }
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
            rest->reach[p].most = qs_max_u64(rest->reach[p].most, rest->label_reach[i]);
        }
    }
}

/* An edge of Potts can cost its weight, if there is a second label. */
static void reach_potts(const qs_remaining *rest)
{
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        rest->reach[p].most = rest->model->labels > 1 ? rest->reach[p].weights : 0;
    }
}

static void reach_sites(const qs_remaining *rest)
{
    memset(rest->reach, 0, sizeof *rest->reach * (size_t)rest->counts.undecided);
    for (uint64_t e = 0; e < rest->counts.edges; e++) {
        const qs_remaining_edge *edge = &rest->edges[e];
        rest->reach[edge->first].weights += (uint64_t)edge->weight;
        rest->reach[edge->second].weights += (uint64_t)edge->weight;
    }
    if (rest->label_reach) {
        reach_labels(rest);
    } else {
        reach_potts(rest);
    }
}

/* No optimum has a label that costs over one more than all the edges of its site can. */
static void truncate_costs(qs_remaining *rest)
{
    for (uint32_t p = 0; p < rest->counts.undecided; p++) {
        int64_t most = (int64_t)rest->reach[p].most + 1;
        for (uint32_t i = rest->start[p]; i < rest->start[p + 1]; i++) {
            int64_t over = qs_max_i64(rest->cost[i] - most, 0);
            rest->overflow |= over > UINT32_MAX;
            rest->trimmed[i] = (uint32_t)over;
            rest->cost[i] -= over;
            rest->trims |= over > 0;
        }
    }
}

void qs_remaining_fill(qs_remaining *rest, const uint8_t *kept)
{
    if (rest->model->pairwise_max > INT32_MAX) { /* the entries of blocks have 32 bits */
        rest->overflow = true;
        return;
    }
    enter_sites(rest, kept);
    enter_edges(rest);
    shift(rest);
    reach_sites(rest);
    if (rest->trimmed) {
        truncate_costs(rest);
    }
}
