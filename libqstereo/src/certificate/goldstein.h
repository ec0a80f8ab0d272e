/* Goldstein's criterion (1994), for any pairwise costs. Let e be one of the labels that a site had
 * in the beginning. Label d is in no optimum if it costs more than e by more than the edges can
 * make up for, whatever labels of their sets the neighbours have:
 *
 *     cost(d) - cost(e) > sum over edges of max_b [cost of (e, b) - cost of (d, b)] */
#ifndef QS_GOLDSTEIN_H
#define QS_GOLDSTEIN_H

#include "stated_problem.h"

/* Takes out of the sets what the criterion rules out, until no more is left than is claimed or the
 * criterion has no more to say. It compares with the cheapest label of a site where a label should
 * leave, and if one stays, everywhere with all: labels that leave elsewhere, though they are
 * claimed to stay, may be why. Only sites that are not settled count, as listed.
 *
 * sets     of each label, as stated->kept, which it replaces here
 * claimed  the sets that should be left
 * due      memory for a byte for each site
 * work     memory for two numbers of each of the most labels
 *
 * Returns true if no label is left that is not claimed */
bool qs_apply_goldstein(const qs_stated *stated, uint8_t *sets, const uint8_t *claimed,
                        uint8_t *due, int64_t *work);

#endif
