/* All samples of an answer at a glance: which are feasible, which one is best, and whether their
 * energies are right. */
#ifndef SURVEY_H
#define SURVEY_H

#include "inputs.h"

typedef struct survey {
    uint32_t feasible;
    uint32_t best; /* the feasible sample of the lowest F, the first one of equals */
    int64_t best_energy; /* F of that one */
    int64_t lowest_energy; /* the least H of all samples, feasible or not */
    uint64_t occurrences;
    uint32_t wrong; /* samples whose energy is not the one that the file states */
    uint32_t first_wrong;
    int64_t stated, found; /* the two energies of that one */
} survey;

/* Computes all energies again and compares those that the file states with them. Returns DONE, or
 * NO_RESOURCE after a message. */
int survey_samples(const answer *looked_at, budget *limit, survey *seen);

/* The labelling of a sample, and F of it: H, and what truncating the costs has cut. `labelling` has
 * room for all sites. Returns what qs_sample_decode returns. */
qs_status sample_labels(const qs_index *index, const uint8_t *bits, uint16_t *labelling,
                        int64_t *energy);

/* When a sample of the problem is feasible, as a clause. */
const char *feasible_means(const qs_qubo *qubo);

/* Prints which energy is wrong. Returns DONE if none is, else BAD_INPUT. */
int survey_fail_wrong(const answer *looked_at, const survey *seen);

#endif
