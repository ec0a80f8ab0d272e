#include "branch.h"

#include <string.h>

#include "../base/minmax.h"

enum {
    ROOT_PASSES = 1000,
    LEVEL_PASSES = 40,
    TRIAL_PASSES = 6,
    CANDIDATES = 8 /* nodes that are tried before one is branched on */
};

static void take_costs(const qs_tables *t, qs_table_costs *c, qs_arena *arena)
{
    c->cells = qs_arena_take(arena, t->cells, sizeof *c->cells);
    c->left = qs_arena_take(arena, t->nodes, sizeof *c->left);
}

void qs_branch_take(qs_branch *b, uint32_t levels, size_t cells, qs_arena *arena)
{
    b->levels = levels;
    for (uint32_t i = 0; i < levels; i++) {
        take_costs(b->t, &b->level[i], arena);
    }
    take_costs(b->t, &b->trial, arena);
    b->labels = qs_arena_take(arena, b->t->nodes, sizeof *b->labels);
    b->found = qs_arena_take(arena, b->t->nodes, sizeof *b->found);
    b->score = qs_arena_take(arena, b->t->nodes, sizeof *b->score);
    b->bucket.t = b->t;
    qs_bucket_take(&b->bucket, cells, arena);
}

/* Tries a problem with a label fixed, or taken out. Returns how far the bound rises; INT64_MAX: no
 * labelling is left. */
static int64_t try_label(qs_branch *b, const qs_table_costs *c, uint32_t node, uint32_t label,
                         bool fix, int64_t most, qs_allowance *work)
{
    qs_tables_copy(b->t, c, &b->trial);
    (fix ? qs_tables_fix : qs_tables_leave)(b->t, &b->trial, node, label);
    (void)qs_spend(work, b->t->cells);
    return qs_tables_tighten(b->t, &b->trial, most, TRIAL_PASSES, work)
               ? b->trial.constant - c->constant
               : INT64_MAX;
}

static bool is_there(const qs_branch *b, const qs_table_costs *c, uint32_t node, uint32_t label)
{
    return c->cells[b->t->start[node] + label] != QS_TABLES_OUT;
}

/* Tries each label of a node. Returns true if any leaves. */
static bool probe_node(qs_branch *b, uint32_t node, qs_allowance *work)
{
    qs_table_costs *c = &b->level[0];
    bool changed = false;
    int64_t least = INT64_MAX;
    for (uint32_t a = 0; a < qs_tables_labels(b->t, node) && work->left > 0; a++) {
        if (!is_there(b, c, node, a) || c->left[node] < 2) {
            continue;
        }
        int64_t rise = try_label(b, c, node, a, true, b->best, work);
        least = qs_min_i64(least, rise);
        if (rise == INT64_MAX) {
            qs_tables_leave(b->t, c, node, a);
            changed = true;
        }
    }
    b->score[node] = least;
    return changed;
}

void qs_branch_probe(qs_branch *b, qs_allowance *work)
{
    qs_table_costs *c = &b->level[0];
    bool again = qs_tables_tighten(b->t, c, b->best, ROOT_PASSES, work);
    while (again && c->constant <= b->best - b->unit && work->left > 0) {
        again = false;
        for (uint32_t p = 0; p < b->t->nodes && work->left > 0; p++) {
            if (c->left[p] > 1 && probe_node(b, p, work)) {
                again = qs_tables_tighten(b->t, c, b->best, LEVEL_PASSES, work);
            }
        }
    }
}

/* Solves what is left at a level by elimination. Returns false if it is too wide for that. */
static bool solve_narrow(qs_branch *b, const qs_table_costs *c, qs_allowance *work)
{
    int64_t value;
    qs_tables_collect(b->t, c);
    if (!qs_bucket_solve(&b->bucket, c, &value, b->found, work)) {
        return false;
    }
    if (value < b->best) {
        b->best = value;
        memcpy(b->labels, b->found, sizeof *b->found * b->t->nodes);
    }
    return true;
}

bool qs_branch_eliminate(qs_branch *b, qs_allowance *work)
{
    qs_table_costs *c = &b->level[0];
    return !qs_tables_tighten(b->t, c, b->best - b->unit, ROOT_PASSES, work) ||
           (work->left > 0 && solve_narrow(b, c, work));
}

static uint32_t cheapest(const qs_branch *b, const qs_table_costs *c, uint32_t node)
{
    const int64_t *costs = c->cells + b->t->start[node];
    uint32_t best = 0;
    for (uint32_t a = 1; a < qs_tables_labels(b->t, node); a++) {
        best = costs[a] < costs[best] ? a : best;
    }
    return best;
}

/* The nodes with the highest scores, at most CANDIDATES. Returns how many. */
static uint32_t find_candidates(const qs_branch *b, const qs_table_costs *c, uint32_t *nodes)
{
    uint32_t count = 0;
    for (uint32_t p = 0; p < b->t->nodes; p++) {
        if (c->left[p] < 2) {
            continue;
        }
        uint32_t at = count < CANDIDATES ? count++ : CANDIDATES;
        for (; at > 0 && b->score[nodes[at - 1]] < b->score[p]; at--) {
            if (at < CANDIDATES) {
                nodes[at] = nodes[at - 1];
            }
        }
        if (at < CANDIDATES) {
            nodes[at] = p;
        }
    }
    return count;
}

typedef enum choice { BRANCH, AGAIN, DEAD } choice;

/* Chooses the node whose cheapest label, fixed as well as taken out, raises the bound most. Where a
 * trial leaves no labelling the problem is changed instead (AGAIN). */
static choice choose(qs_branch *b, qs_table_costs *c, uint32_t *node, qs_allowance *work)
{
    uint32_t nodes[CANDIDATES], count = find_candidates(b, c, nodes);
    int64_t most = b->best - b->unit, best = -1;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t p = nodes[i], a = cheapest(b, c, p);
        int64_t with = try_label(b, c, p, a, true, most, work),
                without = try_label(b, c, p, a, false, most, work);
        if (with == INT64_MAX && without == INT64_MAX) {
            return DEAD;
        }
        if (with == INT64_MAX || without == INT64_MAX) {
            (with == INT64_MAX ? qs_tables_leave : qs_tables_fix)(b->t, c, p, a);
            return AGAIN;
        }
        b->score[p] = 8 * qs_min_i64(with, without) + qs_max_i64(with, without);
        if (b->score[p] > best) {
            best = b->score[p];
            *node = p;
        }
    }
    return count > 0 ? BRANCH : DEAD;
}

/* Sees to a level. Returns BRANCH if it is still open. */
static choice visit(qs_branch *b, qs_table_costs *c, uint32_t *node, qs_allowance *work)
{
    choice next = AGAIN;
    while (next == AGAIN && work->left > 0) {
        if (!qs_tables_tighten(b->t, c, b->best - b->unit, LEVEL_PASSES, work)) {
            return DEAD;
        }
        if (work->left == 0) {
            break;
        }
        if (solve_narrow(b, c, work)) {
            return DEAD;
        }
        next = choose(b, c, node, work);
    }
    return next;
}

/* The least bound of all levels that are open. */
static int64_t open_bound(const qs_branch *b, uint32_t levels)
{
    int64_t bound = b->best;
    for (uint32_t i = 0; i < levels; i++) {
        bound = qs_min_i64(bound, b->level[i].constant);
    }
    int64_t part = bound % b->unit;
    return part > 0 ? bound - part + b->unit : bound;
}

int64_t qs_branch_search(qs_branch *b, qs_allowance *work)
{
    uint32_t levels = 1, node = 0;
    while (levels > 0) {
        qs_table_costs *c = &b->level[levels - 1];
        switch (visit(b, c, &node, work)) {
        case DEAD: levels--; break;
        default:
            if (work->left == 0 || levels == b->levels) {
                return open_bound(b, levels);
            }
            uint32_t label = cheapest(b, c, node);
            qs_tables_copy(b->t, c, &b->level[levels]);
            qs_tables_fix(b->t, &b->level[levels], node, label);
            qs_tables_leave(b->t, c, node, label);
            levels++;
        }
    }
    return b->best;
}
