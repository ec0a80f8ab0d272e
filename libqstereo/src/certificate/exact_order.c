#include "exact_order.h"

#include <string.h>

#include "../base/minmax.h"

void qs_exact_order_take(qs_exact_order *o, const qs_stated *stated, qs_arena *arena)
{
    uint64_t nodes = qs_min_u64(stated->index->qubo->groups, QS_EXACT_SITES);
    o->given = qs_arena_take(arena, nodes, sizeof *o->given);
    o->joined = qs_arena_take(arena, nodes, QS_EXACT_JOINS * sizeof *o->joined);
    o->joins = qs_arena_take(arena, nodes, sizeof *o->joins);
    o->harm = qs_arena_take(arena, nodes, sizeof *o->harm);
}

static uint32_t *joined_to(const qs_exact_order *o, uint32_t i)
{
    return o->joined + (size_t)i * QS_EXACT_JOINS;
}

static bool are_joined(const qs_exact_order *o, uint32_t i, uint32_t other)
{
    const uint32_t *joined = joined_to(o, i);
    bool found = false;
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        found = found || joined[k] == other;
    }
    return found;
}

static bool join(qs_exact_order *o, uint32_t i, uint32_t other)
{
    uint32_t *joined = joined_to(o, i);
    if (are_joined(o, i, other)) {
        return true;
    }
    if (o->joins[i] == QS_EXACT_JOINS) {
        return false;
    }
    joined[o->joins[i]++] = other;
    return true;
}

static void leave(qs_exact_order *o, uint32_t i, uint32_t other)
{
    uint32_t *joined = joined_to(o, i), k = 0;
    while (joined[k] != other) {
        k++;
    }
    joined[k] = joined[--o->joins[i]];
}

/* The costs of all pairs of sites that it would newly join, each of as many as there are pairs of
 * their labels; between two sites of which that is as much, the costs in its table. */
static void find_harm(const qs_exact_order *o, const qs_stated *s, uint32_t i)
{
    const uint32_t *joined = joined_to(o, i);
    uint64_t cells = s->left[o->given[i]], pairs = 0;
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        uint64_t labels = s->left[o->given[joined[k]]];
        cells = qs_min_u64(cells * labels, QS_EXACT_CELLS);
        for (uint32_t m = 0; m < k; m++) {
            pairs +=
                are_joined(o, joined[k], joined[m]) ? 0 : labels * s->left[o->given[joined[m]]];
        }
    }
    o->harm[i] = (pairs << 24) + cells;
}

/* Joins the sites as edges do. */
static bool join_all(qs_exact_order *o, const qs_exact *x)
{
    const qs_stated *s = x->stated;
    bool fits = true;
    memset(o->joins, 0, sizeof *o->joins * x->count);
    for (uint32_t i = 0; i < x->count; i++) {
        uint32_t p = o->given[i];
        for (uint32_t n = s->near_start[p]; fits && n < s->near_start[p + 1]; n++) {
            const qs_stated_edge *edge = &s->edges[s->near[n]];
            uint32_t place = x->place[qs_stated_other(edge, p)];
            fits = !edge->alive || (place > 0 && join(o, i, place - 1));
        }
    }
    for (uint32_t i = 0; i < x->count; i++) {
        find_harm(o, s, i);
    }
    return fits;
}

static uint32_t least_harmful(const qs_exact_order *o, uint32_t count)
{
    uint32_t best = 0;
    uint64_t least = UINT64_MAX;
    for (uint32_t i = 0; i < count; i++) {
        if (o->harm[i] > 0 && o->harm[i] < least) {
            least = o->harm[i];
            best = i;
        }
    }
    return best;
}

/* Takes a site out: all that it is joined to are joined to each other. */
static bool take_out(qs_exact_order *o, const qs_stated *s, uint32_t i)
{
    const uint32_t *joined = joined_to(o, i);
    bool fits = true;
    o->harm[i] = 0;
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        leave(o, joined[k], i);
    }
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        for (uint32_t m = 0; fits && m < o->joins[i]; m++) {
            fits = m == k || join(o, joined[k], joined[m]);
        }
    }
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        find_harm(o, s, joined[k]);
    }
    return fits;
}

static void set_places(const qs_exact_order *o, const qs_exact *x, bool are_there)
{
    for (uint32_t i = 0; i < x->count; i++) {
        x->place[o->given[i]] = are_there ? i + 1 : 0;
    }
}

bool qs_exact_order_find(qs_exact_order *o, qs_exact *x)
{
    memcpy(o->given, x->sites, sizeof *x->sites * x->count);
    set_places(o, x, true);
    bool fits = join_all(o, x);
    set_places(o, x, false);
    for (uint32_t i = 0; fits && i < x->count; i++) {
        uint32_t next = least_harmful(o, x->count);
        x->sites[i] = o->given[next];
        fits = take_out(o, x->stated, next);
    }
    return fits;
}
