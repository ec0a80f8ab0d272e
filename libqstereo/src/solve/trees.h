/* Moves that give many sites their best labels at once (Hamze and de Freitas 2004). A forest is
 * drawn: sites among which edges make no circle. The others keep their labels, and dynamic
 * programming along the trees finds the best labels of all sites in them. For every pairwise cost
 * and every graph; no move raises F. */
#ifndef QS_TREES_H
#define QS_TREES_H

#include "../base/arena.h"
#include "messages.h"

typedef struct qs_trees {
    const qs_model *model;
    qs_scale scale;
    uint32_t *tree; /* of each site in the forest: another one of its tree, or itself */
    uint32_t *degree; /* its edges to sites in the forest that are not done */
    uint32_t *order; /* the sites of the last forest, leaves first: `count` */
    uint32_t count;
    uint32_t *towards; /* of each site the edge (see qs_see_edge) to the one that follows it */
    qs_number *costs; /* sites x labels */
    qs_number *scratch;
} qs_trees;

/* Takes memory. */
void qs_trees_take(qs_trees *trees, const qs_model *model, qs_arena *arena);

/* Begins with a model whose messages fit. */
void qs_trees_begin(qs_trees *trees);

/* One move.
 *
 * sites   that may change, in order, count of them; NULL = all
 * random  what the forest is drawn with */
void qs_trees_move(qs_trees *trees, const uint32_t *sites, uint32_t count, uint64_t *random,
                   uint16_t *labelling);

#endif
