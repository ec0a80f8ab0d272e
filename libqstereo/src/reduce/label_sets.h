/* The label sets of a problem that is being reduced.
 *
 * A label that leaves stays in the arrays, at a cost that keeps it out of every labelling that a
 * solver may find. (Such a cost may be too large for its 31 bits. Then it is the largest there is,
 * and solvers look at the sets: messages.h.) The
 * edges of a site with one label left become costs of its neighbours. So every solver works on the
 * problem as it is at any moment. */
#ifndef QS_LABEL_SETS_H
#define QS_LABEL_SETS_H

#include "../../include/qstereo/model.h"
#include "../base/arena.h"
#include "../solve/number.h"
#include "../solve/progress.h"

typedef struct qs_elimination {
    /* The problem as it is. Labellings of kept labels have the same energies as before. The
     * cheapest kept label of a site costs 0; one that is out costs more than any that is kept,
     * whatever the neighbours. */
    qs_model model;
    int32_t *unary, *right, *down; /* the model's, to be changed */
    qs_link *links;
    uint8_t *kept;
    uint16_t *labelling; /* of kept labels only: if one leaves, its site takes another */
    uint8_t *due; /* of each site: 1 = Goldstein's criterion has not seen it since its costs, or the
                     labels of a neighbour, have changed; 2 = its costs are not in order */
    qs_look *look; /* NULL = nothing stops the criterion; where it is stopped, labels may stay */
    int64_t *saved; /* of each label of a site: what its edges can save it */
    uint32_t *left; /* the sites with edges, in order. Of the others no more can be said, and their
                       labels cost 0 */
    uint32_t left_count;
    uint32_t undecided; /* sites with two labels or more */
    uint64_t variables; /* of those: n - 1 for n labels with walls, else n */
    bool walls;
    bool answer; /* only the labelling and its bound count, not which labels are left */
    /* Of each site left: the first site of its part. A part is all that edges join. */
    uint32_t *part;
    /* Of each site left: 1 = its part is closed, its least energy proven; and the label of the site
     * in a labelling that has it. */
    uint8_t *closed;
    uint16_t *closed_label;
    int64_t *room; /* of each part: how far the scaled bound is below the energy of the labelling */
} qs_elimination;

/* Takes the memory. */
void qs_eliminate_take(qs_elimination *e, const qs_model *model, qs_arena *arena);

/* Lays out all labels of the model's own sets, of a masked cell label 0. The memory has been taken.
 * Solvers may work on e->model from now on; its costs are still those of the model.
 *
 * walls      what `variables` counts
 * kept       sites x labels; filled in, and kept up to date
 * labelling  the caller's; it may be replaced by better ones of kept labels at any time */
void qs_eliminate_lay(qs_elimination *e, const qs_model *model, bool walls, uint8_t *kept,
                      uint16_t *labelling);

/* Then, once: copies the costs, and takes out the labels that Goldstein's criterion rules out. The
 * labelling has been made; where it has a label that goes, it takes another. */
void qs_eliminate_begin(qs_elimination *e);

/* The set of a site has changed: its costs, its label and its neighbours follow. */
void qs_eliminate_follow_set(qs_elimination *e, uint32_t site);

/* After that: takes out what Goldstein's criterion rules out in turn, and lists what is left. */
void qs_eliminate_follow(qs_elimination *e);

/* Finds the room of each part. Parts have been found; the caller may have made one of several.
 * Returns the gap: the sum of the rooms, in units, each rounded down; of parts that are closed 0.
 * The labelling is the best one there: see qs_eliminate_restore.
 *
 * shares  of each site in the bound, times 2^shift (trws.h)
 * room    out: the sum, not rounded */
int64_t qs_eliminate_find_rooms(qs_elimination *e, const int64_t *shares, unsigned shift,
                                int64_t *room);

/* Takes out the labels whose marginals (trws.h) prove that no labelling with them is as good as the
 * present one, each part of the problem for itself. qs_eliminate_follow has to come next.
 *
 * room  out: how far the bound was below the energy of the labelling, times 2^shift
 *
 * Returns the same in units, rounded down in each part. */
int64_t qs_eliminate_above(qs_elimination *e, const qs_natural *marginals, const int64_t *shares,
                           unsigned shift, int64_t *room);

/* The same for parts that have been found: see qs_eliminate_find_rooms. */
int64_t qs_eliminate_above_in_parts(qs_elimination *e, const qs_natural *marginals,
                                    const int64_t *shares, unsigned shift, int64_t *room);

/* Gives closed parts their best labelling again. The caller may have replaced it by one that is
 * better elsewhere. */
void qs_eliminate_restore(qs_elimination *e);

/* Finds the parts. */
void qs_eliminate_find_parts(qs_elimination *e);

/* How many labels are kept at a site. */
uint32_t qs_eliminate_count(const qs_elimination *e, uint32_t site);

bool qs_eliminate_has_edges(const qs_elimination *e, uint32_t site);

/* What the labelling costs at a site. Each edge is counted at its second site. */
int64_t qs_eliminate_cost_at(const qs_elimination *e, uint32_t site);

#endif
