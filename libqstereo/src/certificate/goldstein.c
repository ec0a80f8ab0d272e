#include "goldstein.h"

#include "../base/minmax.h"

/* Whether a label of a site is left, and leaves. */
static bool is_asked(const qs_stated *stated, const uint8_t *claimed, size_t at)
{
    return stated->kept[at] && !claimed[at];
}

/* Adds to the costs of each label d what an edge of the site costs with it, at least, less what it
 * costs with label e. */
static void add_edge(const qs_stated *stated, const qs_stated_edge *edge, uint32_t site, uint32_t e,
                     const uint8_t *claimed, int64_t *costs)
{
    uint32_t other = qs_stated_other(edge, site);
    const uint8_t *theirs = stated->kept + stated->start[other];
    bool is_first = edge->first == site;
    size_t columns = stated->count[edge->second], down = is_first ? columns : 1,
           across = is_first ? 1 : columns;
    const int64_t *table = qs_stated_table(stated, edge), *line_of_e = table + e * down;
    for (uint32_t d = 0; d < stated->count[site]; d++) {
        if (!is_asked(stated, claimed, qs_stated_at(stated, site, d))) {
            continue;
        }
        const int64_t *line = table + d * down;
        int64_t least = INT64_MAX;
        for (uint32_t b = 0; b < stated->count[other]; b++) {
            if (theirs[b]) {
                least =
                    qs_min_i64(least, edge->weight * (line[b * across] - line_of_e[b * across]));
            }
        }
        costs[d] += least;
    }
}

bool qs_goldstein_rules_out(const qs_stated *stated, uint32_t site, uint32_t e,
                            const uint8_t *claimed, int64_t *costs)
{
    const int64_t *unary = stated->unary + stated->start[site];
    for (uint32_t d = 0; d < stated->count[site]; d++) {
        costs[d] = unary[d] - unary[e];
    }
    for (uint32_t n = stated->near_start[site]; n < stated->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &stated->edges[stated->near[n]];
        if (edge->alive) {
            add_edge(stated, edge, site, e, claimed, costs);
        }
    }
    bool all = true;
    for (uint32_t d = 0; d < stated->count[site]; d++) {
        all = all && (!is_asked(stated, claimed, qs_stated_at(stated, site, d)) || costs[d] > 0);
    }
    return all;
}

/* Compares with one label. Returns true if any leaves. */
static bool compare_with(const qs_stated *stated, uint32_t site, uint32_t e, const uint8_t *claimed,
                         uint8_t *sets, int64_t *costs)
{
    bool any = false;
    (void)qs_goldstein_rules_out(stated, site, e, claimed, costs);
    for (uint32_t d = 0; d < stated->count[site]; d++) {
        size_t at = qs_stated_at(stated, site, d);
        bool leaves = is_asked(stated, claimed, at) && costs[d] > 0;
        sets[at] = stated->kept[at] && !leaves;
        any = any || leaves;
    }
    return any;
}

static uint32_t cheapest(const qs_stated *stated, uint32_t site)
{
    uint32_t best = QS_NO_LABEL;
    for (uint32_t a = 0; a < stated->count[site]; a++) {
        size_t at = qs_stated_at(stated, site, a);
        bool is_less = best == QS_NO_LABEL ||
                       stated->unary[at] < stated->unary[qs_stated_at(stated, site, best)];
        best = stated->kept[at] && is_less ? a : best;
    }
    return best;
}

uint32_t qs_goldstein_at(const qs_stated *stated, uint32_t site, const uint8_t *claimed, bool all,
                         uint8_t *sets, int64_t *costs)
{
    uint32_t e = all ? 0 : cheapest(stated, site), end = all ? stated->count[site] : e + 1;
    for (; e < end; e++) {
        if (stated->kept[qs_stated_at(stated, site, e)] &&
            compare_with(stated, site, e, claimed, sets, costs)) {
            return e;
        }
    }
    return QS_NO_LABEL;
}
