/* The candidates of a site in a sample of one-hot-sparse or domain-wall: the labels that its
 * variables offer. In one-hot-sparse these are the labels d with x_pd = 1. In a wall u_1 u_2 ... it
 * is the j-th label (from 0) where u_j = 1 and u_j+1 = 0, with u_0 = 1 and a 0 behind the last; a
 * labelling has one such place. */
#ifndef QS_CANDIDATES_H
#define QS_CANDIDATES_H

#include "../base/bits.h"
#include "../qubo/sites.h"

static inline bool qs_is_wall(const qs_index *index)
{
    return index->qubo->labels.encoding == QS_DOMAIN_WALL;
}

/* Labels left to an undecided site. */
static inline uint32_t qs_site_size(const qs_index *index, uint32_t site)
{
    return index->start[site + 1] - index->start[site] + qs_is_wall(index);
}

/* Returns true if the label of a rank is a candidate. */
static inline bool qs_is_candidate(const qs_index *index, const uint8_t *bits, uint32_t site,
                                   uint32_t rank)
{
    uint32_t from = index->start[site], last = index->start[site + 1] - from;
    if (!qs_is_wall(index)) {
        return qs_bit(bits, from + rank);
    }
    bool one_before = rank == 0 || qs_bit(bits, from + rank - 1);
    bool zero_here = rank == last || !qs_bit(bits, from + rank);
    return one_before && zero_here;
}

/* Their number. */
static inline uint32_t qs_candidates(const qs_index *index, const uint8_t *bits, uint32_t site)
{
    uint32_t count = 0;
    for (uint32_t rank = 0; rank < qs_site_size(index, site); rank++) {
        count += qs_is_candidate(index, bits, site, rank);
    }
    return count;
}

/* Leaves the site the candidate of a rank alone. */
static inline void qs_choose_candidate(const qs_index *index, uint8_t *bits, uint32_t site,
                                       uint32_t rank)
{
    uint32_t from = index->start[site], end = index->start[site + 1];
    bool wall = qs_is_wall(index);
    for (uint32_t i = from; i < end; i++) {
        qs_bit_set(bits, i, wall ? i - from < rank : i - from == rank);
    }
}

#endif
