#include "bucket.h"

#include <string.h>

#include "../base/minmax.h"

enum { WORD = 64 };

#define NONE UINT32_MAX

static size_t words(uint32_t places)
{
    return (places + (size_t)WORD - 1) / WORD;
}

void qs_bucket_take(qs_bucket *b, size_t cells, qs_arena *arena)
{
    uint64_t nodes = b->t->nodes, edges = b->t->edges;
    b->cell_limit = cells;
    b->scopes_limit = (size_t)(nodes * 4 + edges * 2 + cells / 4);
    b->cells = qs_arena_take(arena, cells, sizeof *b->cells);
    b->near = qs_arena_take(arena, nodes * words(b->t->nodes), sizeof *b->near);
    b->gone = qs_arena_take(arena, words(b->t->nodes), sizeof *b->gone);
    b->open = qs_arena_take(arena, nodes, sizeof *b->open);
    b->place = qs_arena_take(arena, nodes, sizeof *b->place);
    b->labels = qs_arena_take(arena, b->t->cells, sizeof *b->labels);
    b->order = qs_arena_take(arena, nodes, sizeof *b->order);
    b->turn = qs_arena_take(arena, nodes, sizeof *b->turn);
    b->fill = qs_arena_take(arena, nodes, sizeof *b->fill);
    b->scopes = qs_arena_take(arena, b->scopes_limit, sizeof *b->scopes);
    b->functions = qs_arena_take(arena, 2 * nodes + edges, sizeof *b->functions);
    b->first = qs_arena_take(arena, nodes, sizeof *b->first);
    b->chosen = qs_arena_take(arena, nodes, sizeof *b->chosen);
}

static bool is_set(const uint64_t *bits, uint32_t at)
{
    return (bits[at / WORD] >> at % WORD & 1) != 0;
}

static void set(uint64_t *bits, uint32_t at)
{
    bits[at / WORD] |= (uint64_t)1 << at % WORD;
}

static uint32_t ones(uint64_t x)
{
    x -= x >> 1 & UINT64_C(0x5555555555555555);
    x = (x & UINT64_C(0x3333333333333333)) + (x >> 2 & UINT64_C(0x3333333333333333));
    x = (x + (x >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f);
    return (uint32_t)(x * UINT64_C(0x0101010101010101) >> 56);
}

/* The next place of a set from `at` on; `count` = none. */
static uint32_t next_of(const uint64_t *bits, uint32_t at, uint32_t count)
{
    while (at < count) {
        uint64_t word = bits[at / WORD] >> at % WORD;
        if (word == 0) {
            at = at / WORD * WORD + WORD;
        } else if ((word & 1) != 0) {
            return at;
        } else {
            at += ones((word & (0 - word)) - 1);
        }
    }
    return count;
}

static uint64_t *near_of(const qs_bucket *b, uint32_t place)
{
    return b->near + place * words(b->count);
}

static uint32_t degree(const qs_bucket *b, uint32_t place)
{
    const uint64_t *near = near_of(b, place);
    uint32_t sum = 0;
    for (size_t w = 0; w < words(b->count); w++) {
        sum += ones(near[w]);
    }
    return sum;
}

/* Twice the pairs of neighbours that are not joined. */
static uint32_t count_fill(const qs_bucket *b, uint32_t place)
{
    const uint64_t *near = near_of(b, place);
    uint32_t fill = 0;
    for (uint32_t q = next_of(near, 0, b->count); q < b->count;
         q = next_of(near, q + 1, b->count)) {
        const uint64_t *other = near_of(b, q);
        for (size_t w = 0; w < words(b->count); w++) {
            fill += ones(near[w] & ~other[w]);
        }
        fill--; /* itself */
    }
    return fill;
}

static uint32_t node_of(const qs_bucket *b, uint32_t place)
{
    return b->open[place];
}

/* Lists the nodes with several labels, and these labels. */
static void list_open(qs_bucket *b, const qs_table_costs *c)
{
    const qs_tables *t = b->t;
    b->count = 0;
    for (uint32_t p = 0; p < t->nodes; p++) {
        uint32_t *labels = b->labels + t->start[p];
        for (uint32_t a = 0; a < qs_tables_labels(t, p); a++) {
            if (c->cells[t->start[p] + a] != QS_TABLES_OUT) {
                *labels++ = a;
            }
        }
        b->place[p] = NONE;
        if (c->left[p] > 1) {
            b->place[p] = b->count;
            b->open[b->count++] = p;
        }
    }
}

/* Returns false if the watch stops it. */
static bool join_neighbours(qs_bucket *b, qs_allowance *work)
{
    bool go = true;
    memset(b->near, 0, sizeof *b->near * b->count * words(b->count));
    for (uint32_t e = 0; e < b->t->edges; e++) {
        uint32_t p = b->place[b->t->edge[e].first], q = b->place[b->t->edge[e].second];
        if (p != NONE && q != NONE) {
            set(near_of(b, p), q);
            set(near_of(b, q), p);
        }
    }
    for (uint32_t p = 0; go && p < b->count; p++) {
        b->fill[p] = count_fill(b, p);
        go = qs_spend(work, b->count + (uint64_t)degree(b, p) * words(b->count));
    }
    return go;
}

/* The place whose leaving joins the fewest pairs; of equals that with the fewest neighbours. */
static uint32_t choose(const qs_bucket *b)
{
    uint32_t best = NONE, best_degree = 0;
    for (uint32_t p = 0; p < b->count; p++) {
        if (is_set(b->gone, p) || (best != NONE && b->fill[p] > b->fill[best])) {
            continue;
        }
        uint32_t near = degree(b, p);
        if (best == NONE || b->fill[p] < b->fill[best] || near < best_degree) {
            best = p;
            best_degree = near;
        }
    }
    return best;
}

/* A place leaves: its neighbours are joined. */
static void leave(qs_bucket *b, uint32_t place)
{
    uint64_t *near = near_of(b, place);
    uint32_t count = b->count;
    set(b->gone, place);
    for (uint32_t q = next_of(near, 0, count); q < count; q = next_of(near, q + 1, count)) {
        uint64_t *other = near_of(b, q);
        for (size_t w = 0; w < words(count); w++) {
            other[w] |= near[w];
        }
        other[q / WORD] &= ~((uint64_t)1 << q % WORD);
        other[place / WORD] &= ~((uint64_t)1 << place % WORD);
    }
    for (uint32_t q = next_of(near, 0, count); q < count; q = next_of(near, q + 1, count)) {
        const uint64_t *other = near_of(b, q);
        b->fill[q] = count_fill(b, q);
        for (uint32_t r = next_of(other, 0, count); r < count; r = next_of(other, r + 1, count)) {
            b->fill[r] = count_fill(b, r);
        }
    }
}

static uint32_t labels_left(const qs_bucket *b, const qs_table_costs *c, uint32_t place)
{
    return c->left[node_of(b, place)];
}

/* The product of the numbers of labels of a scope; 0 = too many. */
static size_t cells_of(const qs_bucket *b, const qs_table_costs *c, const uint32_t *scope,
                       uint32_t size)
{
    size_t cells = 1;
    for (uint32_t i = 0; i < size; i++) {
        uint32_t labels = labels_left(b, c, scope[i]);
        if (cells > b->cell_limit / labels) {
            return 0;
        }
        cells *= labels;
    }
    return cells;
}

/* A new function of a scope, whose table is to be filled in. NULL = no room. */
static qs_bucket_function *add_function(qs_bucket *b, const qs_table_costs *c,
                                        const uint32_t *scope, uint32_t size)
{
    size_t cells = cells_of(b, c, scope, size);
    if (cells == 0 || cells > b->cell_limit - b->cells_used ||
        size > b->scopes_limit - b->scopes_used) {
        return NULL;
    }
    qs_bucket_function *f = &b->functions[b->function_count];
    *f = (qs_bucket_function){b->cells_used, b->scopes_used, size, b->first[scope[0]]};
    memcpy(b->scopes + f->scope, scope, sizeof *scope * size);
    b->first[scope[0]] = b->function_count++;
    b->cells_used += cells;
    b->scopes_used += size;
    return f;
}

/* The neighbours of a place in the order in which they leave: first those that leave soonest. */
static uint32_t list_scope(const qs_bucket *b, uint32_t place, uint32_t *scope)
{
    const uint64_t *near = near_of(b, place);
    uint32_t size = 0;
    for (uint32_t q = next_of(near, 0, b->count); q < b->count;
         q = next_of(near, q + 1, b->count)) {
        uint32_t at = size++;
        for (; at > 0 && b->turn[scope[at - 1]] > b->turn[q]; at--) {
            scope[at] = scope[at - 1];
        }
        scope[at] = q;
    }
    return size;
}

/* Finds an order. The neighbours of a place that has left stay those that it had then. Returns
 * false if a scope is too wide, the tables would take too many numbers, or the watch stops it. */
static bool find_order(qs_bucket *b, const qs_table_costs *c, qs_allowance *work)
{
    size_t cells = 0;
    memset(b->turn, 0, sizeof *b->turn * b->count);
    memset(b->gone, 0, sizeof *b->gone * words(b->count));
    for (uint32_t i = 0; i < b->count; i++) {
        uint32_t p = choose(b), scope[QS_BUCKET_WIDEST];
        b->order[i] = p;
        b->turn[p] = i;
        uint64_t near = degree(b, p);
        if (near > QS_BUCKET_WIDEST || !qs_spend(work, near * near * near * words(b->count))) {
            return false;
        }
        size_t more = cells_of(b, c, scope, list_scope(b, p, scope));
        if (more == 0 || more > b->cell_limit - cells) {
            return false;
        }
        cells += more;
        leave(b, p);
    }
    return true;
}

/* The costs of the nodes and of the edges become functions. */
static bool add_costs(qs_bucket *b, const qs_table_costs *c)
{
    const qs_tables *t = b->t;
    b->cells_used = b->scopes_used = 0;
    b->function_count = 0;
    for (uint32_t p = 0; p < b->count; p++) {
        b->first[p] = NONE;
    }
    for (uint32_t p = 0; p < b->count; p++) {
        uint32_t node = node_of(b, p), begin = t->start[node];
        const qs_bucket_function *f = add_function(b, c, &p, 1);
        for (uint32_t i = 0; f && i < c->left[node]; i++) {
            b->cells[f->table + i] = c->cells[begin + b->labels[begin + i]];
        }
        if (!f) {
            return false;
        }
    }
    for (uint32_t e = 0; e < t->edges; e++) {
        const qs_table_edge *edge = &t->edge[e];
        uint32_t p = b->place[edge->first], q = b->place[edge->second];
        if (p == NONE || q == NONE) {
            continue;
        }
        bool in_order = b->turn[p] < b->turn[q];
        uint32_t scope[2] = {in_order ? p : q, in_order ? q : p}, n[2];
        const qs_bucket_function *f = add_function(b, c, scope, 2);
        if (!f) {
            return false;
        }
        int64_t *out = b->cells + f->table;
        const uint32_t *one = b->labels + t->start[edge->first],
                       *two = b->labels + t->start[edge->second];
        for (n[1] = 0; n[1] < labels_left(b, c, scope[1]); n[1]++) {
            for (n[0] = 0; n[0] < labels_left(b, c, scope[0]); n[0]++) {
                uint32_t a = one[n[in_order ? 0 : 1]], d = two[n[in_order ? 1 : 0]];
                *out++ = c->cells[edge->table + (size_t)a * qs_tables_labels(t, edge->second) + d];
            }
        }
    }
    return true;
}

/* The functions of a bucket, as they are walked through: for each the place in its table, and how
 * far that moves with each node of the scope. The bucket's own node moves it by 1. */
typedef struct walk {
    uint32_t functions, size;
    uint32_t scope[QS_BUCKET_WIDEST], labels[QS_BUCKET_WIDEST], at[QS_BUCKET_WIDEST];
    const int64_t *table[QS_BUCKET_FUNCTIONS];
    size_t step[QS_BUCKET_WIDEST][QS_BUCKET_FUNCTIONS];
} walk;

static bool begin_walk(const qs_bucket *b, const qs_table_costs *c, uint32_t place, walk *w)
{
    w->functions = 0;
    w->size = list_scope(b, place, w->scope);
    for (uint32_t i = 0; i < w->size; i++) {
        w->labels[i] = labels_left(b, c, w->scope[i]);
        w->at[i] = 0;
    }
    for (uint32_t n = b->first[place]; n != NONE; n = b->functions[n].next) {
        const qs_bucket_function *f = &b->functions[n];
        if (w->functions == QS_BUCKET_FUNCTIONS) {
            return false;
        }
        size_t step = labels_left(b, c, place);
        for (uint32_t i = 0, j = 1; i < w->size; i++) {
            bool in = j < f->size && b->scopes[f->scope + j] == w->scope[i];
            w->step[i][w->functions] = in ? step : 0;
            step *= in ? w->labels[i] : 1;
            j += in;
        }
        w->table[w->functions++] = b->cells + f->table;
    }
    return true;
}

static void move(walk *w, uint32_t at, bool back)
{
    size_t times = back ? w->labels[at] - 1 : 1;
    for (uint32_t f = 0; f < w->functions; f++) {
        w->table[f] = back ? w->table[f] - w->step[at][f] * times : w->table[f] + w->step[at][f];
    }
    w->at[at] = back ? 0 : w->at[at] + 1;
}

/* The next labels of the scope. Returns false after the last. */
static bool step(walk *w)
{
    for (uint32_t i = 0; i < w->size; i++) {
        bool back = w->at[i] + 1 == w->labels[i];
        move(w, i, back);
        if (!back) {
            return true;
        }
    }
    return false;
}

static int64_t cost_here(const walk *w, uint32_t label)
{
    int64_t cost = 0;
    for (uint32_t f = 0; f < w->functions; f++) {
        cost += w->table[f][label];
    }
    return cost;
}

/* The label that costs least here. */
static uint32_t best_here(const walk *w, uint32_t labels, int64_t *cost)
{
    uint32_t best = 0;
    *cost = cost_here(w, 0);
    for (uint32_t a = 1; a < labels; a++) {
        int64_t other = cost_here(w, a);
        best = other < *cost ? a : best;
        *cost = qs_min_i64(*cost, other);
    }
    return best;
}

/* A place leaves: what it costs at least becomes a function of its neighbours. Returns false if
 * there is no room, or if the watch stops it. */
static bool eliminate(qs_bucket *b, const qs_table_costs *c, uint32_t place, int64_t *value,
                      qs_allowance *work)
{
    walk w;
    if (!begin_walk(b, c, place, &w)) {
        return false;
    }
    uint32_t labels = labels_left(b, c, place);
    int64_t cost, *out = 0; /* without neighbours it is one number */
    if (w.size > 0) {
        const qs_bucket_function *f = add_function(b, c, w.scope, w.size);
        if (!f) {
            return false;
        }
        out = b->cells + f->table;
    }
    bool go = true, more = true;
    while (go && more) {
        (void)best_here(&w, labels, &cost);
        if (out) {
            *out++ = cost;
        }
        more = step(&w);
        go = qs_spend(work, (uint64_t)labels * w.functions);
    }
    *value += w.size > 0 ? 0 : cost;
    return go;
}

/* Chooses a place's label when those of its neighbours are chosen. */
static void decide(const qs_bucket *b, const qs_table_costs *c, uint32_t place)
{
    walk w;
    int64_t cost;
    (void)begin_walk(b, c, place, &w);
    for (uint32_t i = 0; i < w.size; i++) {
        for (uint32_t n = b->chosen[w.scope[i]]; n > 0; n--) {
            move(&w, i, false);
        }
    }
    b->chosen[place] = best_here(&w, labels_left(b, c, place), &cost);
}

bool qs_bucket_solve(qs_bucket *b, const qs_table_costs *c, int64_t *value, uint32_t *best,
                     qs_allowance *work)
{
    list_open(b, c);
    if (!join_neighbours(b, work) || !find_order(b, c, work) || !add_costs(b, c)) {
        return false;
    }
    *value = c->constant;
    for (uint32_t i = 0; i < b->count; i++) {
        if (!eliminate(b, c, b->order[i], value, work)) {
            return false;
        }
    }
    for (uint32_t i = b->count; i > 0; i--) {
        decide(b, c, b->order[i - 1]);
    }
    for (uint32_t p = 0; p < b->t->nodes; p++) {
        const uint32_t *labels = b->labels + b->t->start[p];
        best[p] = labels[b->place[p] == NONE ? 0 : b->chosen[b->place[p]]];
    }
    return true;
}
