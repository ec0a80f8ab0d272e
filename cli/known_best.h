/* The best labelling known that the file of a problem carries, and the bound that it states. */
#ifndef KNOWN_BEST_H
#define KNOWN_BEST_H

#include "inputs.h"

typedef struct known_best {
    uint16_t *labelling; /* of the problem's sites, in memory of the budget; NULL = it has none */
    int64_t energy; /* F of the labelling */
    int64_t lower_bound; /* that the file states, and nobody has proven here; QS_NO_BOUND = none */
} known_best;

/* Looks for them in a problem that has its index, and computes the energy.
 *
 * Returns DONE or NO_RESOURCE, and has printed why. */
int known_best_open(const problem_file *problem, budget *limit, known_best *known);

#endif
