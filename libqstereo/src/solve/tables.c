#include "tables.h"

#include <string.h>

#include "../base/minmax.h"

enum { WORTH = 64 }; /* two passes are worth it if they gain this part of what is missing */

void qs_tables_link(qs_tables *t)
{
    memset(t->link_start, 0, sizeof *t->link_start * (t->nodes + (size_t)1));
    for (uint32_t e = 0; e < t->edges; e++) {
        t->link_start[t->edge[e].first + 1]++;
        t->link_start[t->edge[e].second + 1]++;
    }
    for (uint32_t p = 0; p < t->nodes; p++) {
        t->link_start[p + 1] += t->link_start[p];
    }
    for (uint32_t e = 0; e < t->edges; e++) {
        t->link[t->link_start[t->edge[e].first]++] = e;
        t->link[t->link_start[t->edge[e].second]++] = e;
    }
    for (uint32_t p = t->nodes; p > 0; p--) {
        t->link_start[p] = t->link_start[p - 1];
    }
    t->link_start[0] = 0;
}

void qs_tables_copy(const qs_tables *t, const qs_table_costs *from, qs_table_costs *to)
{
    to->constant = from->constant;
    memcpy(to->cells, from->cells, sizeof *to->cells * t->cells);
    memcpy(to->left, from->left, sizeof *to->left * t->nodes);
}

void qs_tables_leave(const qs_tables *t, qs_table_costs *c, uint32_t node, uint32_t label)
{
    int64_t *cost = &c->cells[t->start[node] + label];
    c->left[node] -= *cost != QS_TABLES_OUT;
    *cost = QS_TABLES_OUT;
}

void qs_tables_fix(const qs_tables *t, qs_table_costs *c, uint32_t node, uint32_t label)
{
    for (uint32_t a = 0; a < qs_tables_labels(t, node); a++) {
        if (a != label) {
            qs_tables_leave(t, c, node, a);
        }
    }
}

/* An edge as one of its nodes sees it: labels of this node are `step` numbers apart, those of the
 * other one `other_step`. */
typedef struct view {
    int64_t *table;
    const int64_t *other_costs;
    uint32_t other, other_labels, step, other_step;
} view;

static view view_of(const qs_tables *t, const qs_table_costs *c, uint32_t node, uint32_t edge)
{
    const qs_table_edge *e = &t->edge[edge];
    bool first = e->first == node;
    uint32_t other = first ? e->second : e->first, columns = qs_tables_labels(t, e->second);
    return (view){.table = c->cells + e->table,
                  .other_costs = c->cells + t->start[other],
                  .other = other,
                  .other_labels = qs_tables_labels(t, other),
                  .step = first ? columns : 1,
                  .other_step = first ? 1 : columns};
}

/* Moves to a label's cost what the edge costs with it at least. */
static void collect_label(const view *v, uint32_t label, int64_t *cost)
{
    int64_t least = INT64_MAX, *row = v->table + (size_t)label * v->step;
    for (uint32_t b = 0; b < v->other_labels; b++) {
        bool there = v->other_costs[b] != QS_TABLES_OUT;
        least = there ? qs_min_i64(least, row[(size_t)b * v->other_step]) : least;
    }
    if (least == 0) {
        return;
    }
    *cost += least;
    for (uint32_t b = 0; b < v->other_labels; b++) {
        row[(size_t)b * v->other_step] -= v->other_costs[b] != QS_TABLES_OUT ? least : 0;
    }
}

/* Moves to a node what its edges cost whatever the neighbours do. */
static void collect(const qs_tables *t, const qs_table_costs *c, uint32_t node)
{
    int64_t *costs = c->cells + t->start[node];
    for (uint32_t n = t->link_start[node]; n < t->link_start[node + 1]; n++) {
        view v = view_of(t, c, node, t->link[n]);
        for (uint32_t a = 0; a < qs_tables_labels(t, node); a++) {
            if (costs[a] != QS_TABLES_OUT) {
                collect_label(&v, a, &costs[a]);
            }
        }
    }
}

/* Moves the least cost of a node to the constant, and takes out labels that cost too much. Returns
 * false if none is left. */
static bool settle(const qs_tables *t, qs_table_costs *c, uint32_t node, int64_t most)
{
    int64_t *costs = c->cells + t->start[node], least = INT64_MAX;
    uint32_t labels = qs_tables_labels(t, node);
    for (uint32_t a = 0; a < labels; a++) {
        least = qs_min_i64(least, costs[a]); /* OUT is the largest number */
    }
    if (least == QS_TABLES_OUT || c->constant + least > most) {
        return false;
    }
    c->constant += least;
    for (uint32_t a = 0; a < labels; a++) {
        if (costs[a] == QS_TABLES_OUT) {
            continue;
        }
        costs[a] -= least;
        if (costs[a] > most - c->constant) {
            qs_tables_leave(t, c, node, a);
        }
    }
    return true;
}

/* Edges to nodes with one label only are none: what they cost has been collected. */
static bool comes_later(const qs_table_costs *c, const view *v, uint32_t node, bool forward)
{
    return c->left[v->other] > 1 && (v->other > node) == forward;
}

/* Moves equal shares of a node's costs to its edges to later nodes. */
static void share_out(const qs_tables *t, const qs_table_costs *c, uint32_t node, bool forward)
{
    int64_t *costs = c->cells + t->start[node];
    uint32_t later = 0, earlier = 0;
    for (uint32_t n = t->link_start[node]; n < t->link_start[node + 1]; n++) {
        view v = view_of(t, c, node, t->link[n]);
        later += comes_later(c, &v, node, forward);
        earlier += comes_later(c, &v, node, !forward);
    }
    for (uint32_t a = 0; later > 0 && a < qs_tables_labels(t, node); a++) {
        int64_t share = costs[a] / qs_max_u32(later, earlier);
        if (costs[a] == QS_TABLES_OUT || share == 0) {
            continue;
        }
        costs[a] -= share * later;
        for (uint32_t n = t->link_start[node]; n < t->link_start[node + 1]; n++) {
            view v = view_of(t, c, node, t->link[n]);
            for (uint32_t b = 0; comes_later(c, &v, node, forward) && b < v.other_labels; b++) {
                v.table[(size_t)a * v.step + (size_t)b * v.other_step] +=
                    v.other_costs[b] != QS_TABLES_OUT ? share : 0;
            }
        }
    }
}

/* How many numbers a visit of a node looks at. */
static uint64_t work_at(const qs_tables *t, uint32_t node)
{
    uint64_t numbers = 1;
    for (uint32_t n = t->link_start[node]; n < t->link_start[node + 1]; n++) {
        const qs_table_edge *e = &t->edge[t->link[n]];
        numbers += (uint64_t)qs_tables_labels(t, e->first) * qs_tables_labels(t, e->second);
    }
    return numbers;
}

void qs_tables_collect(const qs_tables *t, const qs_table_costs *c)
{
    for (uint32_t p = 0; p < t->nodes; p++) {
        if (c->left[p] > 1) {
            collect(t, c, p);
        }
    }
}

static bool pass(const qs_tables *t, qs_table_costs *c, int64_t most, bool forward,
                 qs_allowance *work)
{
    for (uint32_t i = 0; i < t->nodes; i++) {
        uint32_t p = forward ? i : t->nodes - 1 - i;
        collect(t, c, p);
        if (!settle(t, c, p, most)) {
            return false;
        }
        if (c->left[p] > 1) {
            share_out(t, c, p, forward);
        }
        (void)qs_spend(work, work_at(t, p));
    }
    return true;
}

bool qs_tables_tighten(const qs_tables *t, qs_table_costs *c, int64_t most, uint32_t passes,
                       qs_allowance *work)
{
    int64_t before = c->constant;
    for (uint32_t i = 0; i < passes && work->left > 0; i++) {
        if (!pass(t, c, most, i % 2 == 0, work)) {
            return false;
        }
        if (i % 2 != 0 && c->constant - before <= (most - c->constant) / WORTH) {
            return true;
        }
        before = i % 2 != 0 ? c->constant : before;
    }
    return true;
}
