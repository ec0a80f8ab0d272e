/* A window of a grid as a problem of its own, solved with its neighbours held. */
#ifndef QS_BLOCK_H
#define QS_BLOCK_H

#include "../solve/trws.h"
#include "label_sets.h"
#include "rectangle.h"

typedef struct qs_block {
    qs_rectangle at;
    qs_model model; /* the window; these are its costs: */
    int32_t *unary, *right, *down;
    uint8_t *kept; /* the labels that it has, */
    uint8_t *kept_in; /* and those of them that are left while it is solved */
    uint16_t *labelling, *trial;
    qs_elimination sets;
    qs_trws_state state;
    int64_t *shares;
    uint32_t *marginals; /* and the memory of parts: parts_size bytes */
    size_t parts_size;
    int64_t energy; /* of the labelling */
    int64_t bound; /* of all labellings of the window */
} qs_block;

/* Lays a window out in memory that is aligned for any type. Returns false if it is too small, or
 * if the edges have tables of their own. */
bool qs_block_take(qs_block *b, const qs_model *whole, qs_rectangle at, void *memory, size_t size);

/* Fills it in: the labels that are kept of the window's sites, and what the edges to neighbours
 * outside cost with the labels that these have. So what a labelling of the window gains, the whole
 * gains. The labelling is the window's part of that of the whole, and the energy is its.
 *
 * Returns false if the costs are too large. */
bool qs_block_hold(qs_block *b, const qs_model *whole, const uint16_t *labelling);

/* Brings a site's costs in order: the cheapest kept label costs 0, those that are not kept more
 * than any. Returns what the cheapest one cost before. */
int32_t qs_settle_costs(int32_t *unary, const uint8_t *kept, uint32_t labels);

/* Fills it in as a window that has been cut out of the whole: no edge leads out of it. Cells that
 * are not of the window cost nothing.
 *
 * cut     the whole, its costs in order, and its messages
 * base    of each site: what its costs are above those of `cut`
 * window  of each site: the number of its window; this one's is `number` */
void qs_block_cut(qs_block *b, const qs_trws_state *cut, const int64_t *base, const uint8_t *window,
                  uint8_t number, const uint16_t *labelling);

/* Finds better labellings, and a bound, in a few dozen iterations of messages and as much work on
 * parts.
 *
 * look  ends it early; NULL = nobody looks */
void qs_block_solve(qs_block *b, qs_look *look);

/* The site of the whole that a cell of the window is. */
static inline uint32_t qs_block_site(const qs_block *b, const qs_model *whole, uint32_t cell)
{
    return (b->at.y + cell / b->at.width) * whole->width + b->at.x + cell % b->at.width;
}

#endif
