/* All samples of an answer, looked at once: which are feasible, which is best, and whether the energies are true. */
#ifndef SURVEY_H
#define SURVEY_H

#include "inputs.h"

typedef struct survey {
    uint32_t feasible;
    uint32_t best; /* the feasible sample of the lowest energy, the first of equals */
    int64_t best_energy;
    int64_t lowest_energy; /* of all samples, feasible or not */
    uint64_t occurrences;
    uint32_t wrong; /* samples whose energy is not what the file says */
    uint32_t first_wrong;
    int64_t stated, found; /* the two energies of that one */
} survey;

/* Energies are recomputed; those that the file states are only compared with them. */
survey survey_samples(const answer *looked_at);

/* Says which energy is wrong. Returns DONE where none is, else BAD_INPUT. */
int survey_fail_wrong(const answer *looked_at, const survey *seen);

#endif
