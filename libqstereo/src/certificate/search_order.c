#include <string.h>

#include "../base/minmax.h"
#include "../base/sort.h"
#include "search.h"

/* Adds the least and the most that an edge costs with a label of a site. */
static void add_extremes(const qs_stated *s, const qs_stated_edge *edge, uint32_t site, uint32_t a,
                         int64_t *least, int64_t *most)
{
    uint32_t other = qs_stated_other(edge, site);
    int64_t low = INT64_MAX, high = INT64_MIN;
    for (uint32_t b = 0; b < s->count[other]; b++) {
        if (s->kept[qs_stated_at(s, other, b)]) {
            int64_t cost = qs_stated_cost_from(s, edge, site, a, b);
            low = qs_min_i64(low, cost);
            high = qs_max_i64(high, cost);
        }
    }
    *least += low;
    *most += high;
}

/* How much the choice of a site's label is worth: by how much the cheapest one, if no neighbour
 * stands in its way, costs less than the one that is cheapest if all do. At most 0. */
static int64_t worth_of(const qs_stated *s, uint32_t site)
{
    int64_t best = INT64_MAX, safe = INT64_MAX;
    for (uint32_t a = 0; a < s->count[site]; a++) {
        size_t at = qs_stated_at(s, site, a);
        int64_t least = s->unary[at], most = least;
        for (uint32_t n = s->near_start[site]; s->kept[at] && n < s->near_start[site + 1]; n++) {
            const qs_stated_edge *edge = &s->edges[s->near[n]];
            if (edge->alive) {
                add_extremes(s, edge, site, a, &least, &most);
            }
        }
        best = s->kept[at] ? qs_min_i64(best, least) : best;
        safe = s->kept[at] ? qs_min_i64(safe, most) : safe;
    }
    return best - safe;
}

static bool is_worth_more(const void *context, uint32_t a, uint32_t b)
{
    const int64_t *worth = context;
    return worth[a] < worth[b];
}

void qs_search_order(qs_search *x)
{
    uint32_t count = x->part->count, *order = x->label, *spare = x->edge_start;
    for (uint32_t i = 0; i < count; i++) {
        order[i] = i;
        x->cost[i] = worth_of(x->part->stated, x->part->sites[i]);
    }
    qs_sort(order, spare, count, is_worth_more, x->cost);
    memcpy(spare, x->part->sites, sizeof *spare * count);
    for (uint32_t i = 0; i < count; i++) {
        x->part->sites[i] = spare[order[i]];
    }
}
