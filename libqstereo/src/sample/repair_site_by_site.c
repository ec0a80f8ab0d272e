#include "candidates.h"
#include "../qubo/qubo_energy.h"
#include "../base/fraction.h"
#include "repair.h"

/* Let every site draw one of its candidates, each as likely as the others and by itself. H without
 * its penalties is linear in the variables of each site, so what is expected of it is H of the
 * expected variables; it is not above H of the sample (docs/MATHS.md). Each site in turn takes the
 * candidate that is cheapest beside what is expected of its neighbours: that raises no expectation,
 * and at the end there is nothing left to draw. */

uint64_t qs_alone_workspace(const qs_index *index)
{
    return sizeof(qs_fraction) * (uint64_t)index->qubo->labels.labels;
}

/* Adds to the cost of each of a group's variables what one neighbour is expected to make it cost.
 */
static void add_neighbour(const qs_index *index, const uint8_t *bits, uint32_t site,
                          const qs_neighbour *near, qs_fraction *costs)
{
    bool wall = index->qubo->labels.encoding == QS_DOMAIN_WALL;
    uint32_t own = index->start[site + 1] - index->start[site],
             others = index->start[near->group + 1] - index->start[near->group];
    uint32_t all = qs_candidates(index, bits, near->group), some = 0;
    for (uint32_t j = others; j-- > 0;) {
        /* A wall's variable j is 1 for the candidates of rank j + 1 and higher. */
        bool candidate = qs_is_candidate(index, bits, near->group, j + wall);
        some = (wall ? some : 0) + candidate;
        for (uint32_t i = 0; some > 0 && i < own; i++) {
            int64_t entry = qs_near_entry(index, near, i, j);
            costs[i] = qs_plus(costs[i], qs_share(entry * near->weight, some, all));
        }
    }
}

/* In a wall of label j the variables 0 to j - 1 are 1: of the chain's couplings those of neighbours
 * in it count. */
static void add_chain(const qs_index *index, uint32_t site, const qs_neighbour *near,
                      qs_fraction *costs)
{
    uint32_t own = index->start[site + 1] - index->start[site];
    for (uint32_t i = 1; i < own; i++) {
        costs[i].whole += (int64_t)qs_index_block(index, near->block, i - 1, i) * near->weight;
    }
}

/* Of each rank what it is expected to cost; in a wall less what rank 0 costs. */
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
    qs_fraction sum = {0, 0};
    for (uint32_t rank = 0; index->qubo->labels.encoding == QS_DOMAIN_WALL && rank <= own; rank++) {
        qs_fraction before = sum;
        sum = rank < own ? qs_plus(sum, costs[rank]) : sum;
        costs[rank] = before;
    }
}

void qs_repair_alone(const qs_index *index, uint8_t *bits, void *workspace)
{
    qs_fraction *costs = workspace;
    for (uint32_t p = 0; p < index->qubo->groups; p++) {
        if (qs_candidates(index, bits, p) < 2) {
            continue;
        }
        uint32_t best = UINT32_MAX;
        expect(index, bits, p, costs);
        for (uint32_t rank = 0; rank < qs_site_size(index, p); rank++) {
            bool better = best == UINT32_MAX || qs_less(costs[rank], costs[best]);
            best = qs_is_candidate(index, bits, p, rank) && better ? rank : best;
        }
        qs_choose_candidate(index, bits, p, best);
    }
}
