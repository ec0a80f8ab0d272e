#include "search.h"

#include "../base/minmax.h"

#define NO_LABEL UINT32_MAX

void qs_search_take(qs_search *x, qs_exact *part, qs_arena *arena)
{
    const qs_qubo *qubo = part->stated->index->qubo;
    uint64_t sites = qs_min_u64(qubo->groups, QS_SEARCH_SITES),
             labels = qs_min_u64(qubo->variables + qubo->groups, QS_SEARCH_LABELS),
             edges = qs_min_u64(qubo->couplings, QS_SEARCH_EDGES);
    x->part = part;
    x->least = qs_arena_take(arena, sites + 1, sizeof *x->least);
    x->label_start = qs_arena_take(arena, sites + 1, sizeof *x->label_start);
    x->edge_start = qs_arena_take(arena, sites + 1, sizeof *x->edge_start);
    x->name = qs_arena_take(arena, labels, sizeof *x->name);
    x->unary = qs_arena_take(arena, labels, sizeof *x->unary);
    x->ahead = qs_arena_take(arena, labels, sizeof *x->ahead);
    x->edge = qs_arena_take(arena, edges, sizeof *x->edge);
    x->label = qs_arena_take(arena, sites, sizeof *x->label);
    x->cost = qs_arena_take(arena, sites + 1, sizeof *x->cost);
}

/* ---- Laying out. ---- */

/* What two labels cost on an edge, by their numbers in the search. */
static int64_t cost_of(const qs_search *x, uint32_t place, const qs_search_edge *edge, uint32_t a,
                       uint32_t b)
{
    const qs_stated *s = x->part->stated;
    return qs_stated_cost_from(s, &s->edges[edge->edge], x->part->sites[place], x->name[a],
                               x->name[b]) -
           edge->least;
}

static bool list_labels(qs_search *x)
{
    const qs_stated *s = x->part->stated;
    uint32_t labels = 0;
    for (uint32_t i = 0; i < x->part->count; i++) {
        uint32_t p = x->part->sites[i];
        x->label_start[i] = labels;
        if (s->left[p] > QS_SEARCH_LABELS - labels) {
            return false;
        }
        for (uint32_t a = 0; a < s->count[p]; a++) {
            size_t at = qs_stated_at(s, p, a);
            if (s->kept[at]) {
                x->name[labels] = (uint16_t)a;
                x->unary[labels] = s->unary[at];
                x->ahead[labels++] = 0;
            }
        }
    }
    x->label_start[x->part->count] = labels;
    return true;
}

static int64_t least_of_edge(const qs_search *x, uint32_t place, const qs_search_edge *edge)
{
    int64_t least = INT64_MAX;
    for (uint32_t a = x->label_start[place]; a < x->label_start[place + 1]; a++) {
        for (uint32_t b = x->label_start[edge->to]; b < x->label_start[edge->to + 1]; b++) {
            least = qs_min_i64(least, cost_of(x, place, edge, a, b));
        }
    }
    return least;
}

/* Lists the edges from each site to later ones. The sites have their places. */
static bool list_edges(qs_search *x)
{
    const qs_stated *s = x->part->stated;
    uint32_t edges = 0;
    x->edges_least = 0;
    for (uint32_t i = 0; i < x->part->count; i++) {
        uint32_t p = x->part->sites[i];
        x->edge_start[i] = edges;
        for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
            const qs_stated_edge *edge = &s->edges[s->near[n]];
            uint32_t to = edge->alive ? x->part->place[qs_stated_other(edge, p)] - 1 : 0;
            if (!edge->alive || to < i) {
                continue;
            }
            if (edges == QS_SEARCH_EDGES) {
                return false;
            }
            x->edge[edges] = (qs_search_edge){s->near[n], to, 0};
            x->edge[edges].least = least_of_edge(x, i, &x->edge[edges]);
            x->edges_least += x->edge[edges++].least;
        }
    }
    x->edge_start[x->part->count] = edges;
    return true;
}

bool qs_search_lay(qs_search *x)
{
    bool fits = x->part->count <= QS_SEARCH_SITES && qs_exact_place(x->part) && list_labels(x) &&
                list_edges(x);
    qs_exact_forget(x->part);
    if (fits) {
        x->least[x->part->count] = 0;
    }
    return fits;
}

/* ---- Search. ---- */

/* Adds to what is ahead what the label of a place costs there (sign 1), or takes it back (-1). */
static void decide(const qs_search *x, uint32_t place, int sign)
{
    for (uint32_t e = x->edge_start[place]; e < x->edge_start[place + 1]; e++) {
        const qs_search_edge *edge = &x->edge[e];
        for (uint32_t b = x->label_start[edge->to]; b < x->label_start[edge->to + 1]; b++) {
            x->ahead[b] += sign * cost_of(x, place, edge, x->label[place], b);
        }
    }
}

/* The least of the costs of a place's labels with what is ahead, and of that alone. */
static void find_least(const qs_search *x, uint32_t place, int64_t *whole, int64_t *ahead)
{
    *whole = *ahead = INT64_MAX;
    for (uint32_t a = x->label_start[place]; a < x->label_start[place + 1]; a++) {
        *whole = qs_min_i64(*whole, x->unary[a] + x->ahead[a]);
        *ahead = qs_min_i64(*ahead, x->ahead[a]);
    }
}

/* A bound of what the sites from a place on cost: the best one of all t. */
static int64_t bound(const qs_search *x, uint32_t place)
{
    int64_t best = 0, all_ahead = 0, whole, ahead;
    for (uint32_t t = x->part->count; t-- > place;) {
        find_least(x, t, &whole, &ahead);
        all_ahead += ahead;
        best = qs_max_i64(whole + best, x->least[t] + all_ahead);
    }
    return best;
}

/* The next label of a place by rising cost, of equals the lowest; NO_LABEL after the last. The one
 * before is x->label[place]. */
static uint32_t next_label(const qs_search *x, uint32_t place)
{
    uint32_t last = x->label[place], next = NO_LABEL;
    int64_t before = last != NO_LABEL ? x->unary[last] + x->ahead[last] : INT64_MIN,
            least = INT64_MAX;
    for (uint32_t a = x->label_start[place]; a < x->label_start[place + 1]; a++) {
        int64_t cost = x->unary[a] + x->ahead[a];
        bool is_behind = last == NO_LABEL || cost > before || (cost == before && a > last);
        if (is_behind && cost < least) {
            least = cost;
            next = a;
        }
    }
    return next;
}

/* Gives a place its next label whose bound is low enough. Returns false if there is none, or too
 * much work. */
static bool go_on(qs_search *x, uint32_t from, uint32_t place)
{
    uint32_t labels = x->label_start[x->part->count];
    while ((x->label[place] = next_label(x, place)) != NO_LABEL) {
        uint32_t a = x->label[place];
        if (x->work < labels) {
            x->ended = false;
            return false;
        }
        x->work -= labels;
        x->cost[place + 1] = x->cost[place] + x->unary[a] + x->ahead[a];
        decide(x, place, 1);
        if (x->cost[place + 1] + bound(x, place + 1) < x->least[from]) {
            return true;
        }
        decide(x, place, -1);
    }
    return false;
}

bool qs_search_suffix(qs_search *x, uint32_t from)
{
    uint32_t place = from;
    x->ended = true;
    x->cost[from] = 0;
    x->label[from] = NO_LABEL;
    while (x->ended) {
        if (go_on(x, from, place)) {
            if (place + 1 < x->part->count) {
                x->label[++place] = NO_LABEL;
                continue;
            }
            x->least[from] = x->cost[place + 1];
        } else if (place-- == from) {
            break;
        }
        decide(x, place, -1);
    }
    return x->ended;
}
