/* A search for better labellings of any problem: iterated local search (Lourenco, Martin and
 * Stutzle 2003), but everywhere at once. Some sites get a label by chance, moves on trees
 * (trees.h) follow, and of what comes out every part counts for itself: it is taken over unless it
 * is worse (merge.h). */
#ifndef QS_KICKS_H
#define QS_KICKS_H

#include "merge.h"
#include "progress.h"
#include "trees.h"

/* What goes on from one search to the next. All zero in the beginning. */
typedef struct qs_kicks {
    uint64_t random; /* what is drawn by chance comes from it */
    uint64_t rounds;
} qs_kicks;

enum { QS_KICKS_MOVES = 4 }; /* on trees, in each round */

/* Rounds, until half as many as there were up to the last gain, and at least 64, have gained
 * nothing.
 *
 * sites      that may change, in order, count of them
 * most       rounds at most
 * labelling  of kept labels; out: a better one
 * memory     aligned for any type
 * look       before each round; NULL = nobody looks
 * Returns by how much F has fallen; 0 also if the memory is too small. */
int64_t qs_kicks_improve(qs_kicks *kicks, const qs_model *model, const uint32_t *sites,
                         uint32_t count, uint64_t most, uint16_t *labelling, void *memory,
                         size_t size, qs_look *look);

#endif
