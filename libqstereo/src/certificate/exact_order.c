#include "exact_order.h"

#include <string.h>

#include "../base/minmax.h"

enum { MOST = QS_EXACT_SIDES - 1 };

void qs_exact_order_take(qs_exact_order *o, const qs_stated *stated, qs_arena *arena)
{
    uint64_t nodes = qs_min_u64(stated->index->qubo->groups, QS_EXACT_SITES);
    o->given = qs_arena_take(arena, nodes, sizeof *o->given);
    o->joined = qs_arena_take(arena, nodes, MOST * sizeof *o->joined);
    o->joins = qs_arena_take(arena, nodes, sizeof *o->joins);
    o->cells = qs_arena_take(arena, nodes, sizeof *o->cells);
}

static uint32_t *joined_to(const qs_exact_order *o, uint32_t i)
{
    return o->joined + (size_t)i * MOST;
}

static bool join(qs_exact_order *o, uint32_t i, uint32_t other)
{
    uint32_t *joined = joined_to(o, i);
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        if (joined[k] == other) {
            return true;
        }
    }
    if (o->joins[i] == MOST) {
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

/* A number larger than any limit is as good as any other. */
static void count_cells(const qs_exact_order *o, const qs_stated *s, uint32_t i)
{
    uint64_t cells = s->left[o->given[i]];
    for (uint32_t k = 0; k < o->joins[i] && cells <= QS_EXACT_CELLS; k++) {
        cells *= s->left[o->given[joined_to(o, i)[k]]];
    }
    o->cells[i] = cells;
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
            uint32_t place = x->place[edge->first == p ? edge->second : edge->first];
            fits = !edge->alive || (place > 0 && join(o, i, place - 1));
        }
    }
    for (uint32_t i = 0; i < x->count; i++) {
        count_cells(o, s, i);
    }
    return fits;
}

static uint32_t smallest(const qs_exact_order *o, uint32_t count)
{
    uint32_t best = 0;
    uint64_t least = UINT64_MAX;
    for (uint32_t i = 0; i < count; i++) {
        if (o->cells[i] > 0 && o->cells[i] < least) {
            least = o->cells[i];
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
    o->cells[i] = 0;
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        leave(o, joined[k], i);
    }
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        for (uint32_t m = 0; fits && m < o->joins[i]; m++) {
            fits = m == k || join(o, joined[k], joined[m]);
        }
    }
    for (uint32_t k = 0; k < o->joins[i]; k++) {
        count_cells(o, s, joined[k]);
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
        uint32_t next = smallest(o, x->count);
        x->sites[i] = o->given[next];
        fits = take_out(o, x->stated, next);
    }
    return fits;
}
