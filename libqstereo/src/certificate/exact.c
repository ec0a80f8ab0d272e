#include "exact.h"

#include <string.h>

#include "../base/minmax.h"
#include "../qubo/qcf_runs.h"

/* Costs that the tables of any part can have, up to the limit: no more than each site's table over
 * all labels of all sites. */
static uint64_t most_cells(const qs_qubo *qubo)
{
    uint64_t cells = qubo->groups;
    for (size_t run = 0; run < qubo->group_run_count && cells < QS_EXACT_CELLS; run++) {
        qs_group_run groups = qs_group_run_at(qubo, run);
        for (uint32_t i = 0; i < groups.count && cells < QS_EXACT_CELLS; i++) {
            cells *= (uint64_t)groups.size + 1; /* a domain wall has one label more */
        }
    }
    return qs_min_u64(cells, QS_EXACT_CELLS);
}

void qs_exact_take(qs_exact *x, qs_stated *stated, qs_arena *arena)
{
    const qs_qubo *qubo = stated->index->qubo;
    uint64_t nodes = qs_min_u64(qubo->groups, QS_EXACT_SITES), labels = 0;
    for (size_t run = 0; run < qubo->group_run_count; run++) {
        labels = qs_max_u64(labels, (uint64_t)qs_group_run_at(qubo, run).size + 1);
    }
    *x = (qs_exact){.stated = stated, .capacity = most_cells(qubo)};
    x->sites = qs_arena_take(arena, nodes, sizeof *x->sites);
    x->place = qs_arena_take(arena, qubo->groups, sizeof *x->place);
    x->side = qs_arena_take(arena, nodes, QS_EXACT_SIDES * sizeof *x->side);
    x->sides = qs_arena_take(arena, nodes, sizeof *x->sides);
    x->table_at = qs_arena_take(arena, nodes + 1, sizeof *x->table_at);
    x->tables = qs_arena_take(arena, x->capacity, sizeof *x->tables);
    x->sent = qs_arena_take(arena, x->capacity / 2, sizeof *x->sent);
    uint64_t one = qs_min_u64(x->capacity, x->capacity / 2 + labels * labels);
    x->one = qs_arena_take(arena, one, sizeof *x->one);
    x->names = qs_arena_take(arena, labels, 2 * sizeof *x->names);
    if (x->place) {
        memset(x->place, 0, sizeof *x->place * qubo->groups);
    }
}

/* ---- Laying out. ---- */

static uint32_t *side_of(const qs_exact *x, uint32_t i)
{
    return x->side + (size_t)i * QS_EXACT_SIDES;
}

/* Adds a place to the sides of a table, in order. Returns false if there are too many. */
static bool add_side(qs_exact *x, uint32_t i, uint32_t place)
{
    uint32_t *side = side_of(x, i), at = x->sides[i];
    while (at > 0 && side[at - 1] > place) {
        at--;
    }
    if (at > 0 && side[at - 1] == place) {
        return true;
    }
    if (x->sides[i] == QS_EXACT_SIDES) {
        return false;
    }
    memmove(side + at + 1, side + at, sizeof *side * (x->sides[i] - at));
    side[at] = place;
    x->sides[i]++;
    return true;
}

static bool place_sites(qs_exact *x)
{
    const qs_stated *s = x->stated;
    for (uint32_t i = 0; i < x->count; i++) {
        uint32_t p = x->sites[i];
        if (p >= s->sites || s->settled[p] || x->place[p] != 0) {
            return false;
        }
        x->place[p] = i + 1;
    }
    return true;
}

/* Returns true if edges of the sites lead to their own kind alone. */
static bool is_whole(const qs_exact *x)
{
    const qs_stated *s = x->stated;
    for (uint32_t i = 0; i < x->count; i++) {
        uint32_t p = x->sites[i];
        for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
            const qs_stated_edge *edge = &s->edges[s->near[n]];
            if (edge->alive && x->place[qs_stated_other(edge, p)] == 0) {
                return false;
            }
        }
    }
    return true;
}

bool qs_exact_place(qs_exact *x)
{
    return place_sites(x) && is_whole(x);
}

void qs_exact_forget(qs_exact *x)
{
    for (uint32_t i = 0; i < x->count; i++) {
        if (x->sites[i] < x->stated->sites) {
            x->place[x->sites[i]] = 0;
        }
    }
}

/* The sides of the table of a site are its own place, those of later neighbours, and what the
 * tables that go into it have left. */
static bool find_sides(qs_exact *x, uint32_t i)
{
    const qs_stated *s = x->stated;
    uint32_t p = x->sites[i];
    bool fits = add_side(x, i, i);
    for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
        const qs_stated_edge *edge = &s->edges[s->near[n]];
        uint32_t place = edge->alive ? x->place[qs_stated_other(edge, p)] - 1 : 0;
        fits = fits && (place <= i || add_side(x, i, place));
    }
    for (uint32_t k = 2; fits && k < x->sides[i]; k++) {
        fits = add_side(x, side_of(x, i)[1], side_of(x, i)[k]);
    }
    return fits;
}

static uint32_t labels_at(const qs_exact *x, uint32_t place)
{
    return x->stated->left[x->sites[place]];
}

static bool lay_tables(qs_exact *x)
{
    uint64_t all = 0;
    memset(x->sides, 0, sizeof *x->sides * x->count);
    for (uint32_t i = 0; i < x->count; i++) {
        uint64_t cells = 1;
        if (!find_sides(x, i)) {
            return false;
        }
        for (uint32_t k = 0; k < x->sides[i] && cells <= x->capacity; k++) {
            cells *= labels_at(x, side_of(x, i)[k]);
        }
        x->table_at[i] = (size_t)all;
        all += cells;
        if (all > x->capacity) {
            return false;
        }
    }
    x->table_at[x->count] = (size_t)all;
    return true;
}

qs_exact_laid qs_exact_lay(qs_exact *x)
{
    bool is_part = qs_exact_place(x), fits = is_part && lay_tables(x);
    qs_exact_forget(x);
    if (!is_part) {
        return QS_EXACT_NO_PART;
    }
    return fits ? QS_EXACT_LAID : QS_EXACT_TOO_WIDE;
}

/* ---- Tables. ---- */

/* How two tables are put together. */
typedef enum { ADD, LEAST } combination;

/* Goes through the table of place i, whose first side is the fastest. ADD adds to it another table,
 * over some of its sides; LEAST lowers the other to what it has.
 *
 * side, sides  of the other table: of those of place i some, in the same order */
static void combine(const qs_exact *x, uint32_t i, combination how, int64_t *other,
                    const uint32_t *side, uint32_t sides)
{
    const uint32_t *own = side_of(x, i), own_sides = x->sides[i];
    uint32_t digit[QS_EXACT_SIDES] = {0}, size[QS_EXACT_SIDES], k = 0;
    size_t stride[QS_EXACT_SIDES], next = 1, at = 0;
    for (uint32_t n = 0; n < own_sides; n++) {
        bool has = k < sides && side[k] == own[n];
        size[n] = labels_at(x, own[n]);
        stride[n] = has ? next : 0;
        next *= has ? size[n] : 1;
        k += has;
    }
    for (int64_t *cell = x->tables + x->table_at[i]; cell < x->tables + x->table_at[i + 1];
         cell++) {
        if (how == ADD) {
            *cell += other[at];
        } else {
            other[at] = qs_min_i64(other[at], *cell);
        }
        for (uint32_t n = 0; n < own_sides; n++) {
            at += stride[n];
            if (++digit[n] < size[n]) {
                break;
            }
            at -= stride[n] * size[n];
            digit[n] = 0;
        }
    }
}

static void fill(int64_t *table, size_t cells, int64_t value)
{
    for (size_t c = 0; c < cells; c++) {
        table[c] = value;
    }
}

/* The cells of a table over all sides of place i but its own. */
static size_t cells_beside(const qs_exact *x, uint32_t i)
{
    return (x->table_at[i + 1] - x->table_at[i]) / labels_at(x, i);
}

/* Lists the labels left to a site. */
static uint32_t list_names(const qs_stated *s, uint32_t site, uint32_t *names)
{
    uint32_t count = 0;
    for (uint32_t a = 0; a < s->count[site]; a++) {
        if (s->kept[qs_stated_at(s, site, a)]) {
            names[count++] = a;
        }
    }
    return count;
}

/* Adds the costs of the site at place i to its table. */
static void add_unary(const qs_exact *x, uint32_t i)
{
    const qs_stated *s = x->stated;
    uint32_t p = x->sites[i], count = list_names(s, p, x->names);
    for (uint32_t a = 0; a < count; a++) {
        x->one[a] = s->unary[qs_stated_at(s, p, x->names[a])];
    }
    combine(x, i, ADD, x->one, &i, 1);
}

/* Adds the costs of an edge to a later site. */
static void add_edge(const qs_exact *x, uint32_t i, const qs_stated_edge *edge, uint32_t later)
{
    const qs_stated *s = x->stated;
    uint32_t p = x->sites[i], q = x->sites[later], *names = x->names + s->most_labels;
    uint32_t rows = list_names(s, q, names), columns = list_names(s, p, x->names);
    const uint32_t side[2] = {i, later};
    int64_t *cell = x->one;
    for (uint32_t b = 0; b < rows; b++) {
        for (uint32_t a = 0; a < columns; a++) {
            *cell++ = qs_stated_cost_from(s, edge, p, x->names[a], names[b]);
        }
    }
    combine(x, i, ADD, x->one, side, 2);
}

static void add_edges(const qs_exact *x, uint32_t i)
{
    const qs_stated *s = x->stated;
    uint32_t p = x->sites[i];
    for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
        const qs_stated_edge *edge = &s->edges[s->near[n]];
        uint32_t place = edge->alive ? x->place[qs_stated_other(edge, p)] - 1 : 0;
        if (place > i) {
            add_edge(x, i, edge, place);
        }
    }
}

/* The table of place i is complete: sends the least costs over its own labels on. */
static void send_on(qs_exact *x, uint32_t i)
{
    const uint32_t *side = side_of(x, i);
    int64_t *sent = x->sent + x->table_at[i] / 2;
    fill(sent, cells_beside(x, i), INT64_MAX);
    combine(x, i, LEAST, sent, side + 1, x->sides[i] - 1);
    if (x->sides[i] > 1) {
        combine(x, side[1], ADD, sent, side + 1, x->sides[i] - 1);
    } else {
        x->value += sent[0];
    }
}

/* The table that this one was sent to is complete in both directions: adds what it has beside what
 * was sent. */
static void send_back(qs_exact *x, uint32_t i)
{
    const uint32_t *side = side_of(x, i);
    const int64_t *sent = x->sent + x->table_at[i] / 2;
    size_t cells = cells_beside(x, i);
    if (x->sides[i] == 1) {
        return;
    }
    fill(x->one, cells, INT64_MAX);
    combine(x, side[1], LEAST, x->one, side + 1, x->sides[i] - 1);
    for (size_t c = 0; c < cells; c++) {
        x->one[c] -= sent[c];
    }
    combine(x, i, ADD, x->one, side + 1, x->sides[i] - 1);
}

void qs_exact_solve(qs_exact *x)
{
    (void)place_sites(x);
    x->value = 0;
    fill(x->tables, (size_t)qs_exact_cells(x), 0);
    for (uint32_t i = 0; i < x->count; i++) {
        add_unary(x, i);
        add_edges(x, i);
        send_on(x, i);
    }
    qs_exact_forget(x);
}

/* ---- Settling. ---- */

/* Takes out the labels of the site at place i that cost more than the cheapest. */
static void take_out(const qs_exact *x, uint32_t i)
{
    const qs_stated *s = x->stated;
    uint32_t p = x->sites[i], count = list_names(s, p, x->names);
    int64_t least = INT64_MAX;
    fill(x->one, count, INT64_MAX);
    combine(x, i, LEAST, x->one, &i, 1);
    for (uint32_t a = 0; a < count; a++) {
        least = qs_min_i64(least, x->one[a]);
    }
    for (uint32_t a = 0; a < count; a++) {
        s->kept[qs_stated_at(s, p, x->names[a])] = x->one[a] == least;
    }
}

void qs_exact_settle(qs_exact *x)
{
    qs_stated *s = x->stated;
    for (uint32_t i = x->count; i-- > 0;) {
        send_back(x, i);
    }
    for (uint32_t i = 0; i < x->count; i++) {
        take_out(x, i);
    }
    for (uint32_t i = 0; i < x->count; i++) {
        s->left[x->sites[i]] = list_names(s, x->sites[i], x->names);
    }
    qs_exact_close(x);
}

void qs_exact_close(qs_exact *x)
{
    qs_stated *s = x->stated;
    for (uint32_t i = 0; i < x->count; i++) {
        uint32_t p = x->sites[i];
        s->settled[p] = QS_IN_SOLVED_PART;
        s->open_count--;
        for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
            s->edges[s->near[n]].alive = false;
        }
    }
    s->constant += x->value;
}
