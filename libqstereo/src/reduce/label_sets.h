/* Label sets of a problem that is being reduced. A label that leaves stays in the arrays, at a cost
 * that keeps it out of every labelling that a solver may find (where costs are so large that this
 * one is cut off, by Goldstein's criterion: beside kept labels a kept one is cheaper), and the
 * edges of a site with one label left become costs of its neighbours: so all solvers work on the
 * problem as it is at any moment. */
#ifndef QS_LABEL_SETS_H
#define QS_LABEL_SETS_H

#include "../../include/qstereo/model.h"

typedef struct qs_elimination {
    qs_model model; /* the problem as it is, with the same energies of all labellings of kept
                       labels. The cheapest kept label of a site costs 0; one that is out costs more
                       than any that is kept, whatever the neighbours */
    int32_t *unary, *right, *down; /* its own of these */
    qs_link *links;
    uint8_t *kept;
    uint16_t *labelling; /* of kept labels only; where one leaves, the site takes another */
    uint8_t *due; /* of each site: whether its costs or a neighbour's labels have changed since
                     Goldstein's criterion was looked at */
    int64_t *saved; /* of each label of a site: what its neighbours can save it */
    uint32_t *left; /* the sites with edges, in order: of the others no more can be said, their
                       labels cost 0 */
    uint32_t left_count;
    uint32_t open; /* sites with two labels or more */
    uint64_t variables; /* of those: n - 1 for n labels with walls, else n */
    bool walls;
    uint32_t *part; /* of each site left: the first of all that edges join it to */
    int64_t *room; /* of each part: how far the scaled bound is below the labelling's energy */
} qs_elimination;

/* Bytes of workspace. */
uint64_t qs_eliminate_workspace(const qs_model *model);

/* All labels of the model's own sets, of a masked cell label 0; then what Goldstein's criterion
 * leaves of them.
 *
 * kept       sites x labels, filled in and kept up to date
 * labelling  the winner's; then the caller's to replace by better ones of kept labels */
void qs_eliminate_begin(qs_elimination *e, const qs_model *model, bool walls, void *workspace,
                        uint8_t *kept, uint16_t *labelling);

/* Labels leave whose excess (trws.h) proves that no labelling with them is as good as the present
 * one, each part of the problem for itself; then those that Goldstein's criterion takes out in
 * turn. Returns the gap between labelling and bound that there was, in units, rounded down in each
 * part; *room = the same times 2^shift, not rounded. */
int64_t qs_eliminate_above(qs_elimination *e, const uint32_t *excess, const int64_t *shares,
                           unsigned shift, int64_t *room);

#endif
