/* Label sets of a problem that is being reduced. A label that leaves stays in the arrays, at a cost that keeps it out of every labelling that a solver
 * may find: so all solvers work on the problem as it is at any moment. */
#ifndef QS_ELIMINATE_H
#define QS_ELIMINATE_H

#include "../include/qstereo/model.h"

typedef struct qs_elimination {
    qs_model model;  /* the problem as it is: its `unary`, `kept` and `constant` are of our own. A label that is out costs more than any other of its
                        site, whatever the neighbours; the least of those kept costs 0 */
    int32_t *unary;
    uint8_t *kept;
    uint8_t *due;    /* of each site: whether a neighbour has lost a label since Goldstein's criterion was looked at */
    int64_t *low, *high;   /* of each label of the site that is looked at: between what it costs, whatever the neighbours; less a constant */
    uint16_t *labelling;   /* kept labels only; where one leaves, the site takes another */
} qs_elimination;

/* Bytes of workspace. */
uint64_t qs_eliminate_workspace(const qs_model *model);

/* All labels of the model's own sets; of a masked cell label 0.
 *
 * kept       sites x labels, filled in and kept up to date
 * labelling  the winner's; then the caller's to replace by better ones of kept labels */
void qs_eliminate_begin(qs_elimination *e, const qs_model *model, void *workspace, uint8_t *kept, uint16_t *labelling);

/* Goldstein's criterion (1994; docs/MATHS.md), again until nothing changes: a label leaves that another of its site is better than whatever labels of
 * their sets the neighbours have. For Potts costs; for others a label leaves that costs more by itself than the cheapest can with all its edges. */
void qs_eliminate_goldstein(qs_elimination *e);

/* Labels of an excess (trws.h) above `room` leave. None of the labelling may be among them. */
void qs_eliminate_above(qs_elimination *e, const uint32_t *excess, int64_t room);

/* Sites with two labels or more, and the variables of their labels: n - 1 for n labels with walls, else n. */
uint32_t qs_eliminate_open(const qs_elimination *e, bool walls, uint64_t *variables);

#endif
