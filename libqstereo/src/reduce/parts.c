#include "parts.h"

#include <string.h>

#include "../base/minmax.h"
#include "../model/neighbours.h"
#include "../solve/branch.h"

enum {
    UNITS = 10, /* costs are multiplied by 2^UNITS: then they can be shared out finely */
    MEMORY = 1 << 22, /* bytes that are enough for most problems, */
    BYTES_A_CELL = 256, /* and what a tiny one takes for each of its costs */
    SHARE = 2 /* a part takes at most this part of the work that is allowed */
};

#define NONE UINT32_MAX

/* One part on its way through. */
typedef struct part {
    qs_elimination *e;
    qs_arena arena;
    size_t size; /* of the arena's memory */
    const qs_witness *witness;
    bool only_improve; /* the labelling: no label leaves */
    uint32_t *node; /* of each site its node; NONE = not of this part */
    uint32_t *sites; /* of each node its site */
    uint32_t count;
    qs_tables tables;
    qs_branch search;
    uint8_t *gone; /* of each label of each node: 1 = it leaves */
} part;

static bool has_room(const part *w)
{
    return qs_arena_size(&w->arena) <= w->size;
}

/* Lists the sites of the part of a site, in order. */
static void list_sites(part *w, uint32_t from)
{
    w->count = 0;
    for (uint32_t i = from; i < w->e->left_count && w->count <= QS_PART_NODES; i++) {
        uint32_t p = w->e->left[i];
        if (w->e->part[p] == w->e->part[w->e->left[from]]) {
            w->node[p] = w->count;
            if (w->count < QS_PART_NODES) {
                w->sites[w->count] = p;
            }
            w->count++;
        }
    }
}

static bool is_kept(const qs_elimination *e, uint32_t site, uint32_t label)
{
    return e->kept[(size_t)site * e->model.labels + label] != 0;
}

/* Counts cells and edges. Returns false if they are too many, or the costs too large. */
static bool measure(part *w)
{
    uint64_t cells = 0, edges = 0, total = 0;
    const qs_model *model = &w->e->model;
    for (uint32_t n = 0; n < w->count; n++) {
        uint32_t p = w->sites[n];
        uint64_t labels = qs_eliminate_count(w->e, p), highest = 0;
        for (uint32_t d = 0; d < model->labels; d++) {
            uint64_t cost = (uint64_t)w->e->unary[(size_t)p * model->labels + d];
            highest = is_kept(w->e, p, d) ? qs_max_u64(highest, cost) : highest;
        }
        total += highest + (uint64_t)qs_most_of_edges(model, p);
        cells += labels;
        qs_edge_seen edge;
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            if (edge.weight > 0 && edge.first) {
                cells += labels * qs_eliminate_count(w->e, edge.site);
                edges++;
            }
        }
        if (total >> (QS_TABLES_BITS - UNITS) != 0 || cells > w->size / 8) {
            return false;
        }
    }
    w->tables.nodes = w->count;
    w->tables.edges = (uint32_t)edges;
    w->tables.cells = (uint32_t)cells;
    return true;
}

/* Takes the memory: a half of what is left after the rest for the levels, at most as many as there
 * are; the remainder for elimination. */
static bool take(part *w)
{
    qs_tables *t = &w->tables;
    t->start = qs_arena_take(&w->arena, t->nodes + (uint64_t)1, sizeof *t->start);
    t->edge = qs_arena_take(&w->arena, t->edges, sizeof *t->edge);
    t->link_start = qs_arena_take(&w->arena, t->nodes + (uint64_t)1, sizeof *t->link_start);
    t->link = qs_arena_take(&w->arena, t->edges, 2 * sizeof *t->link);
    w->gone = qs_arena_take(&w->arena, t->cells, sizeof *w->gone);
    if (!has_room(w)) {
        return false;
    }
    w->search.t = t;
    qs_arena fixed = {.base = NULL};
    qs_branch_take(&w->search, 1, 0, &fixed);
    size_t used = qs_arena_size(&w->arena) + qs_arena_size(&fixed);
    if (used > w->size) {
        return false;
    }
    size_t left = w->size - used, level = 8 * (size_t)t->cells + 4 * (size_t)t->nodes + 32;
    size_t levels = left / 2 / level < QS_BRANCH_LEVELS ? left / 2 / level : QS_BRANCH_LEVELS - 1;
    qs_branch_take(&w->search, 1 + (uint32_t)levels, (left - levels * level) / 10, &w->arena);
    return has_room(w);
}

static void fill_edge(part *w, uint32_t p, const qs_edge_seen *seen, qs_table_edge *edge,
                      int64_t *table)
{
    const qs_model *model = &w->e->model;
    *edge = (qs_table_edge){w->node[p], w->node[seen->site],
                            (uint32_t)(table - w->search.level[0].cells)};
    for (uint32_t a = 0; a < model->labels; a++) {
        for (uint32_t b = 0; is_kept(w->e, p, a) && b < model->labels; b++) {
            if (is_kept(w->e, seen->site, b)) {
                *table++ = qs_seen_cost(model, seen, a, b) * ((int64_t)1 << UNITS);
            }
        }
    }
}

/* Lays the part out. */
static void fill(part *w)
{
    qs_tables *t = &w->tables;
    const qs_model *model = &w->e->model;
    qs_table_costs *c = &w->search.level[0];
    uint32_t cells = 0, edges = 0;
    c->constant = 0;
    for (uint32_t n = 0; n < w->count; n++) {
        t->start[n] = cells;
        for (uint32_t d = 0; d < model->labels; d++) {
            if (is_kept(w->e, w->sites[n], d)) {
                c->cells[cells++] = (int64_t)w->e->unary[(size_t)w->sites[n] * model->labels + d] *
                                    ((int64_t)1 << UNITS);
            }
        }
        c->left[n] = cells - t->start[n];
        w->search.score[n] = c->left[n];
    }
    t->start[w->count] = cells;
    for (uint32_t n = 0; n < w->count; n++) {
        qs_edge_seen seen;
        for (uint32_t at = 0; qs_see_edge(model, w->sites[n], at, &seen); at++) {
            if (seen.weight > 0 && seen.first) {
                fill_edge(w, w->sites[n], &seen, &t->edge[edges++], c->cells + cells);
                cells += c->left[n] * c->left[w->node[seen.site]];
            }
        }
    }
    qs_tables_link(t);
}

/* The number of a label among those kept, and back. */
static uint32_t rank_of(const qs_elimination *e, uint32_t site, uint32_t label)
{
    uint32_t rank = 0;
    for (uint32_t d = 0; d < label; d++) {
        rank += is_kept(e, site, d);
    }
    return rank;
}

static uint32_t label_of(const qs_elimination *e, uint32_t site, uint32_t rank)
{
    uint32_t label = 0;
    for (;; label++) {
        if (is_kept(e, site, label) && rank-- == 0) {
            return label;
        }
    }
}

/* What the present labelling costs, without the constant. */
static int64_t energy_of(const part *w)
{
    const qs_model *model = &w->e->model;
    const uint16_t *x = w->e->labelling;
    int64_t energy = 0;
    for (uint32_t n = 0; n < w->count; n++) {
        uint32_t p = w->sites[n];
        qs_edge_seen edge;
        energy += w->e->unary[(size_t)p * model->labels + x[p]];
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            energy += edge.first ? qs_seen_cost(model, &edge, x[p], x[edge.site]) : 0;
        }
    }
    return energy;
}

/* Notes which labels the probe has taken out. */
static void note_gone(part *w)
{
    const qs_table_costs *c = &w->search.level[0];
    for (uint32_t i = 0; i < w->tables.start[w->count]; i++) {
        w->gone[i] = c->cells[i] == QS_TABLES_OUT;
    }
}

/* Labels that the probe has taken out leave the problem. Returns true if there are any. */
static bool take_out(part *w)
{
    qs_elimination *e = w->e;
    bool changed = false;
    for (uint32_t n = 0; n < w->count; n++) {
        const uint8_t *gone = w->gone + w->tables.start[n];
        uint8_t *kept = e->kept + (size_t)w->sites[n] * e->model.labels;
        bool leaves = false;
        for (uint32_t d = 0; d < e->model.labels; d++) {
            bool out = kept[d] && *gone++;
            kept[d] = kept[d] && !out;
            leaves |= out;
        }
        if (leaves) {
            qs_eliminate_follow_set(e, w->sites[n]);
            changed = true;
        }
    }
    return changed;
}

/* Takes over the best labelling. Labels' numbers are still those of the part as it was. */
static void take_labels(part *w, bool closed)
{
    for (uint32_t n = 0; n < w->count; n++) {
        uint32_t p = w->sites[n], label = label_of(w->e, p, w->search.labels[n]);
        w->e->labelling[p] = (uint16_t)label;
        w->e->closed_label[p] = (uint16_t)label;
        w->e->closed[p] = closed;
    }
}

/* Returns true if the bound is above what is below the best labelling. */
static bool is_proven(const part *w)
{
    return w->search.level[0].constant > w->search.best - w->search.unit;
}

/* Begins with the present labelling. Returns what it costs. */
static int64_t begin_search(part *w)
{
    qs_branch *s = &w->search;
    s->unit = (int64_t)1 << UNITS;
    s->best = energy_of(w) * ((int64_t)1 << UNITS);
    for (uint32_t n = 0; n < w->count; n++) {
        s->labels[n] = rank_of(w->e, w->sites[n], w->e->labelling[w->sites[n]]);
    }
    return s->best;
}

/* Only looks for a better labelling. Returns true if there is one. */
static bool improve(part *w, qs_allowance *work)
{
    int64_t energy = begin_search(w);
    (void)qs_branch_search(&w->search, work);
    take_labels(w, false);
    return w->search.best < energy;
}

/* Returns true if anything has changed. */
static bool solve(part *w, qs_allowance *work)
{
    qs_branch *s = &w->search;
    int64_t energy = begin_search(w);
    qs_branch_probe(s, work);
    note_gone(w);
    bool closed = is_proven(w) || qs_branch_search(s, work) == s->best;
    take_labels(w, closed);
    return take_out(w) || closed || s->best < energy;
}

/* Takes the memory for the sites of a part, and lists those of the part of site number i of the
 * list. Returns false if they are too many. */
static bool find_sites(part *w, uint32_t i)
{
    w->node = qs_arena_take(&w->arena, w->e->model.sites, sizeof *w->node);
    w->sites =
        qs_arena_take(&w->arena, qs_min_u32(w->e->model.sites, QS_PART_NODES), sizeof *w->sites);
    if (!has_room(w)) {
        return false;
    }
    list_sites(w, i);
    return w->count <= QS_PART_NODES;
}

/* Lays out and solves the part of site number i of the list. */
static bool see_to(part *w, uint32_t i, qs_allowance *work)
{
    if (!find_sites(w, i) || !measure(w) || !take(w)) {
        return false;
    }
    if (w->witness && !w->witness->part(w->witness->context, w->sites, w->count, !w->e->answer)) {
        return false;
    }
    fill(w);
    uint64_t share = work->left / SHARE + 1;
    qs_allowance own = {share, work->look};
    bool changed = w->only_improve ? improve(w, &own) : solve(w, &own);
    changed |= w->witness != NULL; /* which waits for the next split */
    qs_take_used(work, share, &own);
    return changed;
}

bool qs_parts_solve_one(qs_elimination *e, uint32_t first, void *memory, size_t size,
                        qs_allowance *work, const qs_witness *witness)
{
    part w = {.e = e, .arena = {.base = memory}, .size = size, .witness = witness};
    uint32_t p = e->left[first];
    return work->left > 0 && e->part[p] == p && !e->closed[p] && see_to(&w, first, work);
}

bool qs_parts_solve(qs_elimination *e, void *memory, size_t size, qs_allowance *work,
                    const qs_witness *witness)
{
    bool changed = false;
    qs_eliminate_find_parts(e);
    for (uint32_t i = 0; i < e->left_count; i++) {
        changed |= qs_parts_solve_one(e, i, memory, size, work, witness);
    }
    if (changed) {
        qs_eliminate_follow(e);
    }
    return changed;
}

bool qs_parts_prove(qs_elimination *e, void *memory, size_t size, const qs_witness *witness)
{
    bool any = false;
    qs_eliminate_find_parts(e);
    for (uint32_t i = 0; i < e->left_count; i++) {
        part w = {.e = e, .arena = {.base = memory}, .size = size};
        uint32_t p = e->left[i];
        if (e->part[p] == p && !e->closed[p] && find_sites(&w, i)) {
            any |= witness->part(witness->context, w.sites, w.count, false);
        }
    }
    return any;
}

bool qs_parts_improve(qs_elimination *e, void *memory, size_t size, qs_allowance *work)
{
    bool changed = false;
    qs_eliminate_find_parts(e);
    for (uint32_t i = 0; i < e->left_count && work->left > 0; i++) {
        uint32_t p = e->left[i];
        part w = {.e = e, .arena = {.base = memory}, .size = size, .only_improve = true};
        changed |= e->part[p] == p && !e->closed[p] && see_to(&w, i, work);
    }
    return changed;
}

size_t qs_parts_memory(const qs_model *model)
{
    uint64_t edges = model->width > 0 ? 2 * (uint64_t)model->sites : model->edges,
             labels = model->labels, cells = model->sites * labels + edges * labels * labels;
    return (size_t)qs_min_u64(MEMORY, cells * BYTES_A_CELL);
}
