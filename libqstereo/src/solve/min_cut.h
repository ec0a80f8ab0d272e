/* Minimum cuts, on a 4-neighbour grid whose edges need no lists, on layers of such a grid, or on
 * any graph.
 *
 * A node has an excess (above 0: what its arc from the source still brings) or a want (an excess
 * below 0: what its arc to the sink still takes). An arc between two nodes has a residual: what it
 * still takes.
 *
 * First most of the flow is spread in sweeps over the nodes, as TRW-S spreads messages; what is
 * left is local. Then augmenting paths are searched as Boykov and Kolmogorov (2004) do, but with
 * one tree only, that of the source. In moves nearly every node that is not in this tree has a
 * want, so that a search ends at once. A node enters the tree only when it has no want. */
#ifndef QS_MIN_CUT_H
#define QS_MIN_CUT_H

#include <stdbool.h>

#include "../model/neighbours.h"
#include "number.h"
#include "progress.h"

/* The parent of a node in the tree: the number of the arc to it among the node's arcs; or: */
#define QS_CUT_ORPHAN   (UINT32_MAX - 3)
#define QS_CUT_ROOT     (UINT32_MAX - 2)
#define QS_CUT_FREE     (UINT32_MAX - 1) /* not in the tree */
#define QS_CUT_UNLOADED UINT32_MAX /* not in the tree, and without numbers (as yet) */

typedef struct qs_cut_node {
    uint32_t parent;
    uint32_t stamp; /* when the distance was last known to be right */
    uint16_t distance; /* from the root, at most UINT16_MAX */
    uint8_t active; /* in the queue */
} qs_cut_node;

/* The arcs of a node of a grid. The last two are those to the next and the previous layer. */
enum { QS_CUT_RIGHT, QS_CUT_LEFT, QS_CUT_DOWN, QS_CUT_UP, QS_CUT_ABOVE, QS_CUT_BELOW };

/* The one of these along an edge that a site sees; its weight is above 0. */
static inline uint32_t qs_cut_way(const qs_edge_seen *edge)
{
    return (qs_is_vertical(edge) ? QS_CUT_DOWN : QS_CUT_RIGHT) + (edge->first ? 0U : 1U);
}

/* All memory is the caller's. */
typedef struct qs_cut {
    uint32_t nodes;
    /* Of a grid with `width` more on either side, of layers with `layer` more, all unloaded. */
    qs_cut_node *node;
    qs_number *excess;
    /* Of a grid `nodes` to the right, then `nodes` to the left, down and up, of layers also
     * above and below; those that leave the grid are 0. Of a graph one for each link. */
    qs_number *residual;
    uint32_t layer; /* nodes of each layer; 0 = a flat grid or a graph */
    uint32_t width; /* 0 = a graph: */
    const uint32_t *start; /* as in qs_model */
    const qs_link *links;
    const uint32_t *sister; /* of each link the other link of its edge */
    uint32_t *queue, *orphan; /* `nodes` each */
    size_t queue_first, queue_count, orphan_count;
    uint32_t time;
    /* Gives numbers to an unloaded node, and to others if it likes, and makes them free. None of
     * them has an excess. It is not needed if every arc from a loaded node to an unloaded one has
     * the residual 0. */
    void (*load)(void *context, uint32_t node);
    void *context; /* of load */
    qs_look *look; /* NULL = nothing stops qs_cut_run */
    uint64_t work; /* since the last look */
} qs_cut;

/* Makes ready for the next cut. The caller fills in nodes (free, and the rest of them 0), excess
 * and residuals. */
void qs_cut_begin(qs_cut *cut);

/* Spreads flow without a search, before the sources are named. May be left out.
 *
 * qs_cut_spread       over all nodes, which are loaded
 * qs_cut_spread_some  over those of a list, which is in order; these are loaded
 *
 * They end early where the watch stops them. */
void qs_cut_spread(qs_cut *cut);
void qs_cut_spread_some(qs_cut *cut, const uint32_t *list, uint32_t count);

/* Names a node with an excess. Once for each. */
void qs_cut_source(qs_cut *cut, uint32_t node);

/* Finds the maximum flow. Afterwards the nodes in the tree are the smallest source side of a
 * minimum cut; excess and residual are what is left. Returns false if the watch stopped it: then
 * excess and residual are those of a flow that is not the maximum. */
bool qs_cut_run(qs_cut *cut);

static inline bool qs_cut_in_tree(const qs_cut_node *node)
{
    return node->parent < QS_CUT_FREE;
}

#endif
