/* The problem that remains once labels have been left out: undecided sites, which have two labels
 * or more, and the edges between them. All else is folded into their costs and a constant. */
#ifndef QS_REMAINING_H
#define QS_REMAINING_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"
#include "../base/arena.h"
#include "../encode/penalty.h"
#include "../files/container.h"

/* How much remains. */
typedef struct qs_remaining_counts {
    uint64_t sites; /* of the problem: the model's without the masked cells */
    uint64_t undecided; /* of them */
    uint64_t labels; /* left to the undecided sites */
    uint64_t edges; /* between undecided sites */
    uint64_t thresholds; /* at most, as in qs_encoding_counts */
    bool whole; /* no label has been left out */
    bool empty; /* some site has no label at all */
} qs_remaining_counts;

/* kept           as in qs_recode_options
 * one_is_enough  a problem with one label and nothing left out has undecided sites, of one label */
qs_remaining_counts qs_remaining_count(const qs_model *model, const uint8_t *kept,
                                       bool one_is_enough);

enum { QS_NO_SITE = -1 };

/* An edge of two sites: undecided ones, or the model's. */
typedef struct qs_remaining_edge {
    uint32_t first, second;
    int32_t weight;
    uint32_t edge; /* its number in the model: see qs_model_edge_pairwise */
} qs_remaining_edge;

typedef struct qs_remaining {
    const qs_model *model;
    qs_remaining_counts counts; /* its edges are exact once it has been filled */
    int64_t constant;
    bool overflow; /* a cost does not fit */
    bool no_model; /* a cost, with what truncation takes, is above 2^31 - 1: a model cannot hold
                      it */
    bool trims; /* truncation took something */
    /* Undecided sites, numbered in the order of the model's. */
    int64_t *cost; /* of each label left to each of them; each site's least is 0 */
    uint32_t *trimmed; /* of each such label: what truncation took from its cost; NULL = none */
    uint16_t *label; /* the labels left, rising, one site's after another's */
    uint32_t *start; /* sites + 1: where each one's labels begin */
    qs_site_edges *reach; /* of each: what its edges can cost */
    uint32_t *cell; /* of each: the model's site */
    /* Edges between them. Only in a whole problem is a weight 0. */
    qs_remaining_edge *edges;
    /* The model's sites. */
    int32_t *number; /* of each: the undecided site, or QS_NO_SITE */
    uint16_t *fixed; /* of each that is not undecided: its label */
    /* While it is being filled. */
    uint64_t
        *label_reach; /* of each label left: what the site's edges can cost it; NULL for Potts */
    /* Of a table that all edges share: the largest cost of each row and column. */
    int64_t *row_max, *column_max;
} qs_remaining;

/* Takes the memory. No site is empty. */
qs_remaining qs_remaining_take(qs_arena *arena, const qs_model *model,
                               const qs_remaining_counts *counts, bool truncate);

/* Fills it in. The costs are truncated if there is room for what is trimmed. If `overflow` comes
 * out true, nothing else in it may be used. */
void qs_remaining_fill(qs_remaining *rest, const uint8_t *kept);

/* Labels left to an undecided site. */
static inline uint32_t qs_remaining_size(const qs_remaining *rest, uint32_t site)
{
    return rest->start[site + 1] - rest->start[site];
}

/* Returns true if no label between the first and the last left to a site has been left out. */
static inline bool qs_remaining_is_range(const qs_remaining *rest, uint32_t site)
{
    uint32_t first = rest->label[rest->start[site]], last = rest->label[rest->start[site + 1] - 1];
    return last - first + 1 == qs_remaining_size(rest, site);
}

/* The side chunks kept, trnc and best of the file (docs/FORMAT.md). */
void qs_put_kept(qs_writer *writer, const qs_remaining *rest);
void qs_put_trnc(qs_writer *writer, const qs_remaining *rest);
void qs_put_best(qs_writer *writer, const qs_remaining *rest, const uint16_t *best,
                 int64_t lower_bound);

/* Returns true if all labels of a labelling are left. */
bool qs_remaining_has(const qs_remaining *rest, const uint16_t *labelling);

#endif
