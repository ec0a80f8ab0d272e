#include "remaining.h"

#include <string.h>

#include "../base/saturate.h"
#include "../qubo/sites.h"

/* ---- The model's sites and edges. ---- */

static bool has(const qs_model *model, const uint8_t *kept, uint32_t site, uint32_t label)
{
    return !kept || kept[(size_t)site * model->labels + label] != 0;
}

static uint32_t labels_left(const qs_model *model, const uint8_t *kept, uint32_t site)
{
    uint32_t count = kept ? 0 : model->labels;
    for (uint32_t d = 0; kept && d < model->labels; d++) {
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
    qs_edge edge; /* of the model's sites */
} edge_cursor;

/* The edge at the cursor's cell, if there is one; the cursor moves on. */
static bool grid_edge(edge_cursor *at)
{
    const qs_model *m = at->model;
    uint32_t p = at->site++, q = p + (at->down ? m->width : 1);
    bool inside = at->down ? q < m->sites : q % m->width != 0;
    if (!inside || qs_is_masked(m->mask, p) || qs_is_masked(m->mask, q)) {
        return false;
    }
    at->edge = (qs_edge){p, q, at->down ? m->down[p] : m->right[p]};
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
            at->edge = (qs_edge){at->site, link->site, link->weight};
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

qs_left_counts qs_left_count(const qs_model *model, const uint8_t *kept, bool one)
{
    qs_left_counts c = {.whole = true};
    for (uint32_t p = 0; p < model->sites; p++) {
        uint32_t count = qs_is_masked(model->mask, p) ? model->labels : labels_left(model, kept, p);
        c.whole &= count == model->labels;
        c.empty |= count == 0;
    }
    uint32_t least = c.whole && one ? 1 : 2;
    for (uint32_t p = 0; p < model->sites; p++) {
        if (!qs_is_masked(model->mask, p)) {
            uint32_t count = labels_left(model, kept, p);
            c.sites++;
            c.open += count >= least;
            c.labels += count >= least ? count : 0;
        }
    }
    for (edge_cursor at = {.model = model}; next_edge(&at);) {
        uint32_t first = labels_left(model, kept, at.edge.first),
                 second = labels_left(model, kept, at.edge.second);
        uint64_t both = (uint64_t)first + second + 1, all = (uint64_t)model->labels + 1;
        if (first >= least && second >= least) {
            c.edges++;
            c.thresholds += both < all ? both : all;
        }
    }
    return c;
}

/* ---- Workspace. ---- */

static bool has_table(const qs_model *model)
{
    return model->pairwise.smoothness == QS_TABLE;
}

/* What is needed on the way: the reach of each label, and of a table the maxima of its rows and
 * columns. */
static uint64_t scratch_size(const qs_model *model, const qs_left_counts *c)
{
    bool potts = model->pairwise.smoothness == QS_POTTS;
    return potts ? 0
                 : sizeof(uint64_t) * c->labels +
                       (has_table(model) ? 2 * sizeof(int64_t) * model->labels : 0);
}

uint64_t qs_left_workspace(const qs_model *model, const qs_left_counts *c, bool truncate)
{
    uint64_t wide = sizeof(int64_t) * c->labels + sizeof(qs_site_edges) * c->open;
    uint64_t middle = sizeof(qs_edge) * c->edges + (truncate ? 4 * c->labels : 0) +
                      4 * (c->open + 1) + 4 * c->open + 4 * (uint64_t)model->sites;
    uint64_t narrow = 2 * (uint64_t)model->sites + 2 * c->labels;
    return scratch_size(model, c) + (wide + middle + narrow + 7) / 8 * 8;
}

static char *take(char **at, uint64_t size)
{
    char *here = *at;
    *at += (size_t)size;
    return here;
}

static void lay_out(qs_left *left, bool truncate, void *workspace)
{
    const qs_left_counts *c = &left->counts;
    char *at = (char *)workspace + (size_t)scratch_size(left->model, c);
    left->cost = (int64_t *)(void *)take(&at, sizeof(int64_t) * c->labels);
    left->reach = (qs_site_edges *)(void *)take(&at, sizeof(qs_site_edges) * c->open);
    left->edges = (qs_edge *)(void *)take(&at, sizeof(qs_edge) * c->edges);
    left->excess = truncate ? (uint32_t *)(void *)take(&at, 4 * c->labels) : NULL;
    left->start = (uint32_t *)(void *)take(&at, 4 * (c->open + 1));
    left->cell = (uint32_t *)(void *)take(&at, 4 * c->open);
    left->number = (int32_t *)(void *)take(&at, 4 * (uint64_t)left->model->sites);
    left->fixed = (uint16_t *)(void *)take(&at, 2 * (uint64_t)left->model->sites);
    left->label = (uint16_t *)(void *)take(&at, 2 * c->labels);
}

/* ---- Folding. ---- */

static void enter_sites(qs_left *left, const uint8_t *kept)
{
    const qs_model *m = left->model;
    bool one = left->counts.open ==
               left->counts.sites; /* then those of one label are open, if there are any */
    uint32_t open = 0, at = 0;
    for (uint32_t p = 0; p < m->sites; p++) {
        const int32_t *unary = m->unary + (size_t)p * m->labels;
        uint32_t from = at;
        left->number[p] = QS_NO_SITE;
        if (qs_is_masked(m->mask, p)) {
            continue;
        }
        if (!one && labels_left(m, kept, p) == 1) {
            uint32_t d = 0;
            while (!has(m, kept, p, d)) {
                d++;
            }
            left->fixed[p] = (uint16_t)d;
            qs_add(&left->constant, unary[d], &left->overflow);
            continue;
        }
        for (uint32_t d = 0; d < m->labels; d++) {
            if (has(m, kept, p, d)) {
                left->label[at] = (uint16_t)d;
                left->cost[at++] = unary[d];
            }
        }
        left->number[p] = (int32_t)open;
        left->cell[open] = p;
        left->start[open++] = from;
    }
    left->start[open] = at;
}

/* What an edge to a fixed neighbour costs each label of an open site. */
static void fold(qs_left *left, const qs_edge *edge, bool first_is_open)
{
    const qs_model *m = left->model;
    uint32_t open = (uint32_t)left->number[first_is_open ? edge->first : edge->second];
    uint32_t other = left->fixed[first_is_open ? edge->second : edge->first];
    for (uint32_t i = left->start[open]; i < left->start[open + 1]; i++) {
        uint32_t d = left->label[i];
        qs_add(&left->cost[i],
               edge->weight *
                   qs_model_pairwise(m, first_is_open ? d : other, first_is_open ? other : d),
               &left->overflow);
    }
}

static void enter_edges(qs_left *left)
{
    const qs_model *m = left->model;
    uint64_t count = 0;
    for (edge_cursor at = {.model = m}; next_edge(&at);) {
        const qs_edge *edge = &at.edge;
        int32_t first = left->number[edge->first], second = left->number[edge->second];
        if (edge->weight == 0 && !left->counts.whole) {
            continue;
        }
        if (first != QS_NO_SITE && second != QS_NO_SITE) {
            left->edges[count++] = (qs_edge){(uint32_t)first, (uint32_t)second, edge->weight};
        } else if (first != QS_NO_SITE || second != QS_NO_SITE) {
            fold(left, edge, first != QS_NO_SITE);
        } else {
            qs_add(&left->constant,
                   edge->weight *
                       qs_model_pairwise(m, left->fixed[edge->first], left->fixed[edge->second]),
                   &left->overflow);
        }
    }
    left->counts.edges = count;
}

static void shift(qs_left *left)
{
    for (uint32_t p = 0; p < left->counts.open; p++) {
        int64_t least = INT64_MAX;
        for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
            least = left->cost[i] < least ? left->cost[i] : least;
        }
        for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
            left->cost[i] -= least;
            left->overflow |= left->cost[i] > QS_ENERGY_MAX;
            left->no_model |= left->cost[i] > INT32_MAX;
        }
        qs_add(&left->constant, least, &left->overflow);
    }
}

/* ---- What the edges can cost. ---- */

typedef struct table_maxima {
    int64_t *row, *column; /* of each label, over all labels of the other site */
} table_maxima;

static table_maxima find_maxima(const qs_left *left, void *workspace)
{
    const qs_model *m = left->model;
    table_maxima maxima = {(int64_t *)workspace + left->counts.labels, NULL};
    if (!has_table(m)) {
        return maxima;
    }
    maxima.column = maxima.row + m->labels;
    memset(maxima.row, 0, 2 * sizeof *maxima.row * m->labels);
    for (uint32_t a = 0; a < m->labels; a++) {
        for (uint32_t b = 0; b < m->labels; b++) {
            int64_t cost = qs_model_pairwise(m, a, b);
            maxima.row[a] = cost > maxima.row[a] ? cost : maxima.row[a];
            maxima.column[b] = cost > maxima.column[b] ? cost : maxima.column[b];
        }
    }
    return maxima;
}

/* The largest V of a label beside those that are left to another open site; `first` = the label is
 * V's first. */
static int64_t largest_cost(const qs_left *left, const table_maxima *maxima, uint32_t label,
                            uint32_t other, bool first)
{
    const qs_model *m = left->model;
    const uint16_t *labels = left->label + left->start[other];
    uint32_t count = qs_left_size(left, other);
    if (!has_table(m)) {
        int64_t low = qs_model_pairwise(m, label, labels[0]),
                high = qs_model_pairwise(m, label, labels[count - 1]);
        return low > high ? low : high; /* V rises with the distance */
    }
    if (count == m->labels) {
        return first ? maxima->row[label] : maxima->column[label];
    }
    int64_t largest = 0;
    for (uint32_t i = 0; i < count; i++) {
        int64_t cost =
            first ? qs_model_pairwise(m, label, labels[i]) : qs_model_pairwise(m, labels[i], label);
        largest = cost > largest ? cost : largest;
    }
    return largest;
}

static void reach_labels(const qs_left *left, void *workspace)
{
    uint64_t *reach = workspace;
    table_maxima maxima = find_maxima(left, workspace);
    memset(reach, 0, sizeof *reach * (size_t)left->counts.labels);
    for (uint64_t e = 0; e < left->counts.edges; e++) {
        const qs_edge *edge = &left->edges[e];
        for (int side = 0; side < 2; side++) {
            uint32_t p = side == 0 ? edge->first : edge->second,
                     q = side == 0 ? edge->second : edge->first;
            for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
                qs_grow(&reach[i], (uint64_t)edge->weight,
                        (uint64_t)largest_cost(left, &maxima, left->label[i], q, side == 0));
            }
        }
    }
    for (uint32_t p = 0; p < left->counts.open; p++) {
        for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
            left->reach[p].most = reach[i] > left->reach[p].most ? reach[i] : left->reach[p].most;
        }
    }
}

static void reach_sites(const qs_left *left, void *workspace)
{
    bool potts = left->model->pairwise.smoothness == QS_POTTS;
    memset(left->reach, 0, sizeof *left->reach * (size_t)left->counts.open);
    for (uint64_t e = 0; e < left->counts.edges; e++) {
        const qs_edge *edge = &left->edges[e];
        left->reach[edge->first].weights += (uint64_t)edge->weight;
        left->reach[edge->second].weights += (uint64_t)edge->weight;
    }
    if (!potts) {
        reach_labels(left, workspace);
    }
    for (uint32_t p = 0; potts && p < left->counts.open; p++) {
        left->reach[p].most = left->model->labels > 1 ? left->reach[p].weights : 0;
    }
}

static void truncate_costs(qs_left *left)
{
    for (uint32_t p = 0; p < left->counts.open; p++) {
        int64_t most = (int64_t)left->reach[p].most + 1;
        for (uint32_t i = left->start[p]; i < left->start[p + 1]; i++) {
            int64_t over = left->cost[i] > most ? left->cost[i] - most : 0;
            left->overflow |= over > UINT32_MAX;
            left->excess[i] = (uint32_t)over;
            left->cost[i] -= over;
            left->cut |= over > 0;
        }
    }
}

qs_left qs_left_make(const qs_model *model, const uint8_t *kept, const qs_left_counts *counts,
                     bool truncate, void *workspace)
{
    /* Entries of blocks have 32 bits. */
    qs_left left = {.model = model,
                    .counts = *counts,
                    .constant = model->constant,
                    .overflow = model->pairwise_max > INT32_MAX};
    lay_out(&left, truncate, workspace);
    if (left.overflow) {
        return left;
    }
    enter_sites(&left, kept);
    enter_edges(&left);
    shift(&left);
    reach_sites(&left, workspace);
    if (truncate) {
        truncate_costs(&left);
    }
    return left;
}
