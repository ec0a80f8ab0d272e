/* All samples of an answer, looked at once: which are feasible, which is best, and whether the
 * energies are true. */
#ifndef SURVEY_H
#define SURVEY_H

#include "inputs.h"

typedef struct survey {
    uint32_t feasible;
    uint32_t best; /* the feasible sample of the lowest F, the first of equals */
    int64_t best_energy; /* F of that one */
    int64_t lowest_energy; /* the least H of all samples, feasible or not */
    uint64_t occurrences;
    uint32_t wrong; /* samples whose energy is not what the file says */
    uint32_t first_wrong;
    int64_t stated, found; /* the two energies of that one */
} survey;

/* Energies are recomputed; those that the file states are only compared with them. Returns DONE or
 * NO_RESOURCE, having said why. */
int survey_samples(const answer *looked_at, budget limit, survey *seen);

/* The labelling of a sample and F of it: H, and what truncating the costs has cut. `labelling` has
 * room for all sites, as for qs_sample_decode, whose status is returned. */
qs_status sample_labels(const qs_index *index, const uint8_t *bits, uint16_t *labelling,
                        int64_t *energy);

/* What makes a sample of the problem feasible, as words after "feasible: ". */
const char *feasible_means(const qs_qubo *qubo);

/* Says which energy is wrong. Returns DONE where none is, else BAD_INPUT. */
int survey_fail_wrong(const answer *looked_at, const survey *seen);

#endif
