/* Minimum cuts on a 4-neighbour grid with implicit neighbours, on layers of such a grid, or on any
 * graph.
 *
 * A node has an excess (its arc from the source) or a want (its arc to the sink: a negative
 * excess), an arc a residual. First much of the flow is spread in sweeps, as messages are in TRW-S:
 * what is left is local. Then augmenting paths are searched as Boykov and Kolmogorov (2004) do,
 * with one tree only, that of the source: in moves nearly every node that is not in it wants flow,
 * so the search ends at once. A node enters the tree only when it wants nothing. */
#ifndef QS_MIN_CUT_H
#define QS_MIN_CUT_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"

/* Parents: the number of the arc among the node's own, or: */
#define QS_CUT_ORPHAN   (UINT32_MAX - 3)
#define QS_CUT_ROOT     (UINT32_MAX - 2)
#define QS_CUT_FREE     (UINT32_MAX - 1) /* not in the tree */
#define QS_CUT_UNLOADED UINT32_MAX /* not in the tree, and its numbers are not there (yet) */

typedef struct qs_cut_node {
    uint32_t parent;
    uint32_t stamp; /* the time when the distance was known to be right */
    uint16_t distance; /* from the root, saturated */
    uint8_t active; /* in the queue */
} qs_cut_node;

/* Arcs of a node of a grid; the last two of layers of grids, to the next and the previous layer. */
enum { QS_CUT_RIGHT, QS_CUT_LEFT, QS_CUT_DOWN, QS_CUT_UP, QS_CUT_ABOVE, QS_CUT_BELOW };

/* All memory is the caller's. */
typedef struct qs_cut {
    uint32_t nodes;
    qs_cut_node *node; /* of a grid `width` more before and behind (of layers `layer`), all
                          unloaded */
    int32_t *excess;
    int32_t *residual; /* of a grid, arc by arc: `nodes` to the right, then `nodes` to the left,
                          ..., 0 out of the grid; of a graph one a link */
    uint32_t layer; /* nodes of each layer; 0 = a flat grid or a graph */
    uint32_t width; /* 0 = a graph: */
    const uint32_t *start; /* as in qs_model */
    const qs_link *links;
    const uint32_t *sister; /* the opposite link of each */
    uint32_t *queue, *orphan; /* `nodes` each */
    size_t queue_first, queue_count, orphan_count;
    uint32_t time;
    /* Gives numbers to an unloaded node (and others, if it likes), no excess, and frees it. Not
     * called where every arc from a loaded node to an unloaded one has residual 0. */
    void (*load)(void *context, uint32_t node);
    /* Called now and then; returns false to stop qs_cut_run. NULL = nothing stops it. */
    bool (*going)(void *context);
    void *context; /* of both */
} qs_cut;

/* Empties the queue for the next cut. Nodes, excess and residuals are the caller's to fill: a node
 * free and the rest of it 0. */
void qs_cut_begin(qs_cut *cut);

/* Sends flow ahead without a search; may be left out. All nodes must be loaded, or for _some those
 * of the list, which is in order. Before the sources are told. */
void qs_cut_spread(qs_cut *cut);
void qs_cut_spread_some(qs_cut *cut, const uint32_t *list, uint32_t count);

/* Tells of a node with an excess, once. */
void qs_cut_source(qs_cut *cut, uint32_t node);

/* The maximum flow. Then the nodes in the tree are the smallest source side of a minimum cut, and
 * excess and residual are what is left. Returns false where `going` stopped it: then excess and
 * residual are those of a flow that is not the maximum. */
bool qs_cut_run(qs_cut *cut);

static inline bool qs_cut_in_tree(const qs_cut_node *node)
{
    return node->parent < QS_CUT_FREE;
}

#endif
