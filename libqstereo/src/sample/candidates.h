/* The candidates of a site in a sample of one-hot-sparse or domain-wall: the labels d with x_pd =
 * 1, where in a wall x of its j-th label is u_j - u_j+1 (u_0 = 1, one behind the last is 0). */
#ifndef QS_CANDIDATES_H
#define QS_CANDIDATES_H

#include "../base/bits.h"
#include "../qubo/sites.h"

/* Labels left to an undecided site. */
static inline uint32_t qs_site_size(const qs_index *index, uint32_t site)
{
    return index->start[site + 1] - index->start[site] +
           (index->qubo->labels.encoding == QS_DOMAIN_WALL);
}

/* Whether the label of a rank is a candidate. */
static inline bool qs_is_candidate(const qs_index *index, const uint8_t *bits, uint32_t site,
                                   uint32_t rank)
{
    uint32_t from = index->start[site], last = index->start[site + 1] - from;
    if (index->qubo->labels.encoding != QS_DOMAIN_WALL) {
        return qs_bit(bits, from + rank);
    }
    return (rank == 0 || qs_bit(bits, from + rank - 1)) &&
           (rank == last || !qs_bit(bits, from + rank));
}

static inline uint32_t qs_candidates(const qs_index *index, const uint8_t *bits, uint32_t site)
{
    uint32_t count = 0;
    for (uint32_t rank = 0; rank < qs_site_size(index, site); rank++) {
        count += qs_is_candidate(index, bits, site, rank);
    }
    return count;
}

/* Leaves one candidate. */
static inline void qs_choose_candidate(const qs_index *index, uint8_t *bits, uint32_t site,
                                       uint32_t rank)
{
    uint32_t from = index->start[site], end = index->start[site + 1];
    bool wall = index->qubo->labels.encoding == QS_DOMAIN_WALL;
    for (uint32_t i = from; i < end; i++) {
        qs_bit_set(bits, i, wall ? i - from < rank : i - from == rank);
    }
}

#endif
