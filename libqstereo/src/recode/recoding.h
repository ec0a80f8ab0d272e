/* What the encoders of qs_recode share. */
#ifndef QS_RECODING_H
#define QS_RECODING_H

#include "../../include/qstereo/recode.h"
#include "../encode/qcf_writer.h"
#include "remaining.h"

/* What a block of a draft stands for. */
typedef enum qs_block_kind {
    QS_PAIR_BLOCK, /* the pairwise cost of two sites */
    QS_CHAIN_BLOCK, /* u_i+1 after u_i of a domain wall */
    QS_TERMINAL_BLOCK, /* a site beside a terminal */
    QS_SCALAR_BLOCK /* 1: of two single variables */
} qs_block_kind;

/* A block, by two open sites that it is the block of. */
typedef struct qs_block_of {
    qs_block_kind kind;
    uint32_t first, second;
} qs_block_of;

typedef struct qs_recoding {
    qs_left left;
    qs_draft draft;
    qs_encoding encoding;
    qs_penalty penalty;
    uint64_t alpha, gap;
    int64_t force; /* of st-cut-arcs: what holds an arc's variable to its vertices' */
    qs_block_of *blocks; /* of the draft */
    uint32_t *set; /* of each open site: the number of its label set */
    uint32_t *order, *scratch; /* as many as there are open sites or edges, whichever are more */
} qs_recoding;

/* Numbers the sites' label sets and leaves the sites in `order`, sorted by set. */
void qs_number_sets(qs_recoding *r);

/* Appends a block to the draft and returns its number. */
uint32_t qs_add_block(qs_recoding *r, qs_block_of block);

/* Couples the groups of all pairs of neighbours by their pairwise cost, a block for each two sets
 * that meet. Disturbs `order`. */
void qs_couple_neighbours(qs_recoding *r);

/* The winner-takes-all labelling's energy, without the constant. */
uint64_t qs_winner_energy(const qs_left *left);

/* The encoders. Each fills the draft. */
void qs_recode_one_hot(qs_recoding *r);
void qs_recode_wall(qs_recoding *r);
void qs_recode_multiway(qs_recoding *r);
void qs_recode_cut(qs_recoding *r);

#endif
