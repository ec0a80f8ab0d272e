#include "../base/arena.h"
#include "../base/fraction.h"
#include "../qubo/qubo_energy.h"
#include "candidates.h"
#include "repair.h"

/* Let each site draw one of its candidates at random, each with the same probability and
 * independently of the others. H without its penalties is linear in the variables of each site, so
 * its expectation is H of the expected variables, and that is not above H of the sample
 * (docs/MATHS.md). Now each site in turn takes the candidate that is cheapest beside the
 * expectations of its neighbours. That never raises the expectation of H. In the end nothing is
 * random any more, and the expectation is H of the labelling. */

/* The costs of a site's labels. */
static qs_fraction *take_costs(qs_arena *arena, const qs_index *index)
{
    return qs_arena_take(arena, index->qubo->labels.labels, sizeof(qs_fraction));
}

size_t qs_site_by_site_workspace(const qs_index *index)
{
    qs_arena arena = {0};
    take_costs(&arena, index);
    return qs_arena_size(&arena);
}

/* Adds to the cost of each of a group's variables what one neighbour is expected to add to it. */
static void add_neighbour(const qs_index *index, const uint8_t *bits, uint32_t site,
                          const qs_neighbour *near, qs_fraction *costs)
{
    bool wall = qs_is_wall(index);
    uint32_t own = index->start[site + 1] - index->start[site],
             others = index->start[near->group + 1] - index->start[near->group];
    uint32_t all = qs_candidates(index, bits, near->group), above = 0;
    for (uint32_t j = others; j-- > 0;) {
        /* A wall's variable j is 1 for the candidates of rank j + 1 and higher. */
        uint32_t here = qs_is_candidate(index, bits, near->group, j + wall);
        above += here;
        uint32_t some = wall ? above : here;
        for (uint32_t i = 0; some > 0 && i < own; i++) {
            int64_t entry = qs_near_entry(index, near, i, j);
            costs[i] = qs_plus(costs[i], qs_share(entry * near->weight, some, all));
        }
    }
}

/* In a wall of rank r the variables 0 to r - 1 are 1. The chain couples each two neighbours among
 * them. */
static void add_chain(const qs_index *index, uint32_t site, const qs_neighbour *near,
                      qs_fraction *costs)
{
    uint32_t own = index->start[site + 1] - index->start[site];
    for (uint32_t i = 1; i < own; i++) {
        costs[i].whole += (int64_t)qs_index_block(index, near->block, i - 1, i) * near->weight;
    }
}

/* A wall's label of rank r has the first r variables at 1: its cost is the sum of theirs. */
static void sum_wall(qs_fraction *costs, uint32_t variables)
{
    qs_fraction sum = {0, 0};
    for (uint32_t i = 0; i < variables; i++) {
        qs_fraction own = costs[i];
        costs[i] = sum;
        sum = qs_plus(sum, own);
    }
    costs[variables] = sum;
}

/* The expected cost of each rank; in a wall less that of rank 0. */
static void expect(const qs_index *index, const uint8_t *bits, uint32_t site, qs_fraction *costs)
{
    uint32_t from = index->start[site], own = index->start[site + 1] - from;
    for (uint32_t i = 0; i < own; i++) {
        costs[i] = (qs_fraction){qs_qubo_linear(index->qubo, from + i), 0};
    }
    for (uint32_t n = index->near_start[site]; n < index->near_start[site + 1]; n++) {
        const qs_neighbour *near = &index->near[n];
        if (near->group == site) {
            add_chain(index, site, near, costs);
        } else {
            add_neighbour(index, bits, site, near, costs);
        }
    }
    if (qs_is_wall(index)) {
        sum_wall(costs, own);
    }
}

void qs_repair_site_by_site(const qs_index *index, uint8_t *bits, void *workspace)
{
    qs_arena arena = {.base = workspace};
    qs_fraction *costs = take_costs(&arena, index);
    for (uint32_t p = 0; p < index->qubo->groups; p++) {
        if (qs_candidates(index, bits, p) < 2) {
            continue;
        }
        expect(index, bits, p, costs);
        uint32_t best = UINT32_MAX;
        for (uint32_t rank = 0; rank < qs_site_size(index, p); rank++) {
            bool better = best == UINT32_MAX || qs_less(costs[rank], costs[best]);
            if (better && qs_is_candidate(index, bits, p, rank)) {
                best = rank;
            }
        }
        qs_choose_candidate(index, bits, p, best);
    }
}
