#include "goldstein.h"

#include <string.h>

#include "../base/minmax.h"

/* Returns the number of labels of a set; `only` is the last of them. */
static uint32_t count_set(const uint8_t *set, uint32_t count, uint32_t *only)
{
    uint32_t left = 0;
    for (uint32_t a = 0; a < count; a++) {
        left += set[a];
        *only = set[a] ? a : *only;
    }
    return left;
}

/* The costs of a site's labels with what the edges to neighbours of one label add. */
static void find_costs(const qs_stated *stated, const uint8_t *sets, uint32_t site, int64_t *costs)
{
    uint32_t count = stated->count[site], only = 0;
    memcpy(costs, stated->unary + stated->start[site], sizeof *costs * count);
    for (uint32_t n = stated->near_start[site]; n < stated->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &stated->edges[stated->near[n]];
        uint32_t other = qs_stated_other(edge, site);
        if (edge->alive &&
            count_set(sets + stated->start[other], stated->count[other], &only) == 1) {
            for (uint32_t a = 0; a < count; a++) {
                costs[a] += qs_stated_cost_from(stated, edge, site, a, only);
            }
        }
    }
}

static uint32_t cheapest(const int64_t *costs, const uint8_t *set, uint32_t count)
{
    uint32_t best = UINT32_MAX;
    for (uint32_t a = 0; a < count; a++) {
        best = set[a] && (best == UINT32_MAX || costs[a] < costs[best]) ? a : best;
    }
    return best;
}

/* Adds to `gains`, for each label d, the most by which the edge can be cheaper with d than with the
 * label `best`. Edges to neighbours of one label are in the costs already. */
static void add_gains(const qs_stated *stated, const uint8_t *sets, const qs_stated_edge *edge,
                      uint32_t site, uint32_t best, int64_t *gains)
{
    uint32_t other = qs_stated_other(edge, site), only;
    const uint8_t *own = sets + stated->start[site], *theirs = sets + stated->start[other];
    if (count_set(theirs, stated->count[other], &only) == 1) {
        return;
    }
    for (uint32_t d = 0; d < stated->count[site]; d++) {
        int64_t most = INT64_MIN;
        for (uint32_t b = 0; own[d] && b < stated->count[other]; b++) {
            if (theirs[b]) {
                most = qs_max_i64(most, qs_stated_cost_from(stated, edge, site, best, b) -
                                            qs_stated_cost_from(stated, edge, site, d, b));
            }
        }
        gains[d] += own[d] ? most : 0;
    }
}

/* Takes out the labels that `best` rules out. Returns true if there is one. */
static bool compare_with(const qs_stated *stated, uint8_t *sets, uint32_t site, uint32_t best,
                         const int64_t *costs, int64_t *gains)
{
    uint32_t count = stated->count[site];
    uint8_t *set = sets + stated->start[site];
    memset(gains, 0, sizeof *gains * count);
    for (uint32_t n = stated->near_start[site]; n < stated->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &stated->edges[stated->near[n]];
        if (edge->alive) {
            add_gains(stated, sets, edge, site, best, gains);
        }
    }
    bool changed = false;
    for (uint32_t d = 0; d < count; d++) {
        bool leaves = set[d] && costs[d] - costs[best] > gains[d];
        set[d] = (uint8_t)(set[d] && !leaves);
        changed = changed || leaves;
    }
    return changed;
}

/* Applies the criterion at a site. Returns true if a label leaves.
 *
 * all  compare with every label, not only with the cheapest */
static bool apply_at(const qs_stated *stated, uint8_t *sets, uint32_t site, bool all, int64_t *work)
{
    uint32_t count = stated->count[site], only = 0;
    /* A label may have left by now: labellings with it are labellings all the same. */
    const uint8_t *first = stated->kept + stated->start[site];
    int64_t *costs = work, *gains = work + stated->most_labels;
    if (count_set(sets + stated->start[site], count, &only) == 1) {
        return false;
    }
    find_costs(stated, sets, site, costs);
    if (!all) {
        return compare_with(stated, sets, site, cheapest(costs, first, count), costs, gains);
    }
    bool changed = false;
    for (uint32_t best = 0; best < count; best++) {
        changed = (first[best] && compare_with(stated, sets, site, best, costs, gains)) || changed;
    }
    return changed;
}

/* The sites around one, and itself, are due. */
static void call_again(const qs_stated *stated, uint32_t site, uint8_t *due)
{
    due[site] = 1;
    for (uint32_t n = stated->near_start[site]; n < stated->near_start[site + 1]; n++) {
        const qs_stated_edge *edge = &stated->edges[stated->near[n]];
        due[qs_stated_other(edge, site)] = 1;
    }
}

static bool has_more(const qs_stated *stated, const uint8_t *sets, const uint8_t *claimed,
                     uint32_t site)
{
    bool more = false;
    for (size_t at = stated->start[site]; at < stated->start[site + 1]; at++) {
        more = more || (sets[at] && !claimed[at]);
    }
    return more;
}

/* At the sites that are due, until none is.
 *
 * claimed  NULL, or only where a label is left that is not in it */
static void apply_to_due(const qs_stated *stated, uint8_t *sets, const uint8_t *claimed,
                         uint8_t *due, int64_t *work)
{
    bool again = true;
    while (again) {
        again = false;
        for (uint32_t i = 0; i < stated->open_count; i++) {
            uint32_t p = stated->open[i];
            if (due[p]) {
                due[p] = 0;
                bool wanted = !claimed || has_more(stated, sets, claimed, p);
                if (wanted && apply_at(stated, sets, p, false, work)) {
                    call_again(stated, p, due);
                    again = true;
                }
            }
        }
    }
}

/* Sets `due` where a label is left that is not claimed. Returns true if there is one. */
static bool find_due(const qs_stated *stated, const uint8_t *sets, const uint8_t *claimed,
                     uint8_t *due)
{
    bool any = false;
    for (uint32_t i = 0; i < stated->open_count; i++) {
        uint32_t p = stated->open[i];
        due[p] = has_more(stated, sets, claimed, p);
        any = any || due[p];
    }
    return any;
}

bool qs_apply_goldstein(const qs_stated *stated, uint8_t *sets, const uint8_t *claimed,
                        uint8_t *due, int64_t *work)
{
    if (!find_due(stated, sets, claimed, due)) {
        return true;
    }
    apply_to_due(stated, sets, claimed, due, work); /* mostly that is all */
    bool again = find_due(stated, sets, claimed, due);
    memset(due, 1, stated->sites);
    while (again) {
        again = false;
        apply_to_due(stated, sets, NULL, due, work);
        for (uint32_t i = 0; i < stated->open_count; i++) {
            uint32_t p = stated->open[i];
            if (apply_at(stated, sets, p, true, work)) {
                call_again(stated, p, due);
                again = true;
            }
        }
    }
    return !find_due(stated, sets, claimed, due);
}
