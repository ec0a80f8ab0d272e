/* What the encoders of qs_recode share. */
#ifndef QS_RECODER_H
#define QS_RECODER_H

#include "../../include/qstereo/recode.h"
#include "draft.h"
#include "remaining.h"

/* What a block of a draft stands for. */
typedef enum qs_block_kind {
    QS_PAIR_BLOCK, /* the pairwise cost of two sites */
    QS_CHAIN_BLOCK, /* u_i+1 after u_i of a domain wall */
    QS_TERMINAL_BLOCK, /* a site beside a terminal */
    QS_SCALAR_BLOCK /* 1: of two single variables */
} qs_block_kind;

/* A block, named by two undecided sites that it couples. */
typedef struct qs_block_of {
    qs_block_kind kind;
    uint32_t first, second;
    uint32_t edge; /* of a pair block: the number of their edge in the model */
} qs_block_of;

typedef struct qs_recoder {
    qs_remaining rest;
    qs_draft draft;
    qs_encoding encoding;
    qs_penalty penalty;
    uint64_t alpha, gap;
    int64_t force; /* of st-cut-arcs: what holds an arc's variable to its vertices' */
    qs_block_of *blocks; /* of the draft */
    uint32_t *set; /* of each undecided site: the number of its label set */
    /* As many numbers as there are undecided sites or edges, whichever are more. */
    uint32_t *order, *scratch;
    /* Of a domain wall whose kappa comes from V itself (wall_kappa.c); else NULL. Of each undecided
     * site: kappa less the gap, twice, for either choice. */
    int64_t *first_choice, *last_choice;
    bool takes_last; /* the choice */
} qs_recoder;

/* Numbers the label sets of the sites, and puts the sites into `order`, sorted by their sets. */
void qs_number_sets(qs_recoder *r);

/* Appends a block to the draft and returns its number. */
uint32_t qs_add_block(qs_recoder *r, qs_block_of block);

/* Couples the groups of all neighbours by their pairwise cost, with a block for each two label sets
 * of which two sites are neighbours. Where edges have tables of their own there is a block for each
 * edge that is not like the one before. Overwrites `order`. */
void qs_couple_neighbours(qs_recoder *r);

/* Sorts the numbers of the edges by the label sets of their sites, into `order`. */
void qs_order_edges(qs_recoder *r);

/* Returns true if two edges of undecided sites have the same label sets and costs. */
bool qs_edges_are_like(const qs_recoder *r, const qs_remaining_edge *x, const qs_remaining_edge *y);

/* Returns true if the kappa of a domain wall comes from the values of V: where it is neither Potts
 * nor linear. */
bool qs_kappa_is_of_values(const qs_pairwise *pairwise);

/* Finds the kappa of all sites, for qs_kappa_of_values. The sets have been numbered. Overwrites
 * `order`. */
void qs_find_kappa(qs_recoder *r);
int64_t qs_kappa_of_values(const qs_recoder *r, uint32_t site);

/* The energy, without the constant, of the labelling in which each site takes its cheapest
 * label. */
uint64_t qs_winner_energy(const qs_remaining *rest);

/* The encoders. Each fills in the draft of a problem with undecided sites. */
typedef void qs_recode_into(qs_recoder *r);
void qs_recode_one_hot(qs_recoder *r);
void qs_recode_wall(qs_recoder *r);
void qs_recode_multiway(qs_recoder *r);
void qs_recode_cut(qs_recoder *r);

#endif
