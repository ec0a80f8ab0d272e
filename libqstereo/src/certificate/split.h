/* A split of a problem among chains, and what it proves (docs/MATHS.md, section 19).
 *
 * Each site that is not settled has slots, one or more. Each edge that is alive stands in one slot
 * of its first site and in one of its second. A slot has at most one edge to a later site and at
 * most one to an earlier site. So the edges make chains that go through the sites in rising order.
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
    uint32_t *sites, count; /* that are not settled, rising */
    const uint16_t *labelling; /* of each site of the problem; NULL = no label leaves */
    uint32_t *slot_start, *slot_count; /* of each site: the number of its first slot among all, and
                                          how many it has */
    uint64_t slots; /* of all */
    uint32_t *next_edge, *before_edge; /* of each slot: to a later, an earlier site; or none */
    const uint8_t *shares; /* in the file: of each site, of each slot but its last, of each label
                              left */
    unsigned share_bytes; /* 1, 2, 4 or 8 */
    size_t *share_at; /* of each site: how many numbers are before its own */
    uint32_t *part; /* of each site: the first site of its part, which is all that chains join */
    int64_t *least; /* of each part: the least costs of its chains together */
    int64_t *room; /* of each part: how far that is below what the labelling costs */
    int64_t
        *along; /* of each edge, for each label: what a chain costs up to the edge, or from it */
    int64_t *work; /* for go_through and come_back */
    uint16_t *open; /* the labels left to a site, for a moment */
} qs_split;

/* Hands out the memory, or counts it. */
void qs_split_take(qs_split *split, const qs_stated *stated, qs_arena *arena);

/* Begins a split of what is not settled. */
void qs_split_begin(qs_split *split, int64_t scale, const uint16_t *labelling);

/* The number of edges that are alive. */
uint64_t qs_split_count_edges(const qs_split *split);

/* Reads the slots of these edges, two numbers of `bytes` bytes each: of each site in turn, of its
 * edges to later sites. Returns false if they make no chains. */
bool qs_split_set_slots(qs_split *split, const uint8_t *slots, unsigned bytes);

/* Lays out the shares and returns how many numbers they are. */
uint64_t qs_split_count_shares(qs_split *split);

/* The bound that the split proves. Finds the rooms of the parts. */
int64_t qs_split_bound(qs_split *split);

/* After qs_split_bound: returns true if each label that is left, and is not claimed to stay, is
 * ruled out: the chains of its part cost more with it than the labelling does there.
 *
 * claimed  of each label of the problem: 1 = it stays */
bool qs_split_rules_out(qs_split *split, const uint8_t *claimed);

#endif
