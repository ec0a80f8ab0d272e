/* The labelling problem that a .qcf states, for the checker of certificates.
 *
 * It is read from the file's coefficients alone: what each label of each undecided site adds to H,
 * and a table of costs for each coupling. Neither the pairwise cost V nor a model takes part. So a
 * certificate is about the file, and its checker shares no reasoning with the solvers.
 *
 * Sites are the groups of the file, labels are those that the file leaves to them, counted from 0.
 * In a domain wall a label is the number of its variables that are 1.
 *
 * Labels leave; a site with one label left is settled: its costs go into the constant, its edges
 * into the costs of its neighbours. The sites of a part that has been solved (exact.h) are settled,
 * too, whatever is left to them. An edge is alive while neither of its sites is settled. */
#ifndef QS_STATED_PROBLEM_H
#define QS_STATED_PROBLEM_H

#include "../../include/qstereo/qubo.h"
#include "../base/arena.h"

/* A coupling of two groups whose weight is not 0. */
typedef struct qs_stated_edge {
    uint32_t first, second; /* sites, first < second */
    uint32_t block;
    int32_t weight;
    bool alive;
} qs_stated_edge;

/* Why a site is settled. */
enum { QS_HAS_ONE_LABEL = 1, QS_IN_SOLVED_PART = 2 };

typedef struct qs_stated {
    const qs_index *index;
    uint32_t sites, edge_count, most_labels;
    int64_t constant;
    uint64_t magnitude; /* no energy, and no part of one, is larger; at most 2^53 + 1 */
    const uint32_t *count; /* labels of each site */
    const size_t *start; /* sites + 1: number of the first label of each site among all labels */
    int64_t *unary; /* of each label */
    uint8_t *kept; /* of each label: 1 = it is left */
    uint32_t *left; /* how many labels are left to each site */
    uint32_t *fixed; /* of a site with one label left: which one */
    uint8_t *settled; /* of each site: not 0 = it is no longer of the problem */
    uint32_t open_count; /* sites that are not settled */
    qs_stated_edge *edges; /* in the order of the file */
    const uint32_t *near_start, *near; /* the numbers of the edges of each site */
    const size_t *table_at; /* where the table of each block begins */
    const int64_t *tables;
} qs_stated;

/* Hands out the memory, or counts it. The index is there; its file has labels in an encoding that
 * qs_stated_takes. */
void qs_stated_take(qs_stated *stated, const qs_index *index, qs_arena *arena);

/* Returns true if states of the file's encoding are labellings group by group: one-hot,
 * one-hot-sparse, domain-wall. */
bool qs_stated_takes(const qs_qubo *qubo);

/* Reads the problem; all labels of the file are left. */
void qs_stated_read(qs_stated *stated);

/* The number of a label among all. */
static inline size_t qs_stated_at(const qs_stated *stated, uint32_t site, uint32_t label)
{
    return stated->start[site] + label;
}

/* The table of an edge: rows are the labels of its first site. Times the edge's weight it is what
 * the labels cost. */
static inline const int64_t *qs_stated_table(const qs_stated *stated, const qs_stated_edge *edge)
{
    return stated->tables + stated->table_at[edge->block];
}

/* What two labels cost on an edge. */
static inline int64_t qs_stated_cost(const qs_stated *stated, const qs_stated_edge *edge,
                                     uint32_t a, uint32_t b)
{
    size_t columns = stated->count[edge->second];
    return edge->weight * qs_stated_table(stated, edge)[a * columns + b];
}

/* The same, with label a at `site` and b at the other end. */
static inline int64_t qs_stated_cost_from(const qs_stated *stated, const qs_stated_edge *edge,
                                          uint32_t site, uint32_t a, uint32_t b)
{
    return edge->first == site ? qs_stated_cost(stated, edge, a, b)
                               : qs_stated_cost(stated, edge, b, a);
}

/* The other end of an edge of a site. */
static inline uint32_t qs_stated_other(const qs_stated_edge *edge, uint32_t site)
{
    return edge->first == site ? edge->second : edge->first;
}

/* After `kept` has changed at a site: counts its labels, and if one is left, turns the site's edges
 * into costs of their other ends. */
void qs_stated_fold(qs_stated *stated, uint32_t site);
void qs_stated_fold_all(qs_stated *stated);

/* What a labelling costs: a label of each site, which may have left. Only before any site has been
 * settled. */
int64_t qs_stated_energy(const qs_stated *stated, const uint16_t *labelling);

#endif
