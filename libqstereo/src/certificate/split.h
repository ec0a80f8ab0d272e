/* A split of a problem among chains, and what it proves (docs/MATHS.md, section 19).
 *
 * Each site has slots, one or more. Each edge that is alive stands in one slot of its first site
 * and in one of its second. A slot has at most one edge to a later site and at most one to an
 * earlier site. So the edges make chains that go through the sites in rising order.
 *
 * All costs are multiplied by `scale`. Each slot but the last has a share of its site's costs, any
 * whole numbers; the last slot has what is left. Then the least costs of all chains, each of which
 * a dynamic program finds, come to no more than `scale` times the cost of any labelling. */
#ifndef QS_SPLIT_H
#define QS_SPLIT_H

#include "stated_problem.h"

#define QS_NO_EDGE UINT32_MAX

typedef struct qs_split {
    const qs_stated *stated;
    int64_t scale;
    uint32_t *slot_start, *slot_count; /* of each site that is not settled: the number of its first
                                          slot among all, and how many it has */
    uint64_t slots; /* of all */
    uint32_t *next_edge, *before_edge; /* of each slot: to a later, an earlier site; or none */
    const uint8_t *shares; /* in the file: of each site that is not settled, of each slot but its
                              last, of each label left */
    unsigned share_bytes; /* 1, 2, 4 or 8 */
    size_t *share_at; /* of each site: how many numbers are before its own */
    uint32_t *part; /* of each site: the first site of its part, which is all that edges join */
    int64_t *least; /* of each part: the least costs of its chains together */
    int64_t
        *along; /* of each edge, for each label: what a chain costs up to the edge, or from it */
    int64_t *excess; /* of each label */
    int64_t *work; /* three numbers for each of the most labels */
    uint16_t *open; /* the labels left to a site, for each of the most */
} qs_split;

/* Hands out the memory, or counts it. */
void qs_split_take(qs_split *split, const qs_stated *stated, qs_arena *arena);

/* Puts the edges that are alive into their slots, and finds the parts. The problem's lists are new.
 *
 * slots  two numbers of `bytes` bytes for each of these edges: its slot at its first and at its
 *        second site. Below the number of the site's edges in the file
 *
 * Returns false if they are not as they must be. */
bool qs_split_set_slots(qs_split *split, const uint8_t *slots, unsigned bytes);

/* How many shares there are: sets share_at. */
uint64_t qs_split_count_shares(qs_split *split);

/* Finds the least costs. Returns the bound of all labellings of labels left, in units, each part
 * rounded up. */
int64_t qs_split_bound(qs_split *split);

/* After qs_split_bound: finds of each label how much more than the least the chains through its
 * site cost, if the site has it: `excess`. */
void qs_split_excess(qs_split *split);

#endif
