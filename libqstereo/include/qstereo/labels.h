/* What a .qcf says about the labelling problem behind its QUBO (docs/FORMAT.md,
 * side chunks labl, mean, kept and trnc). */
#ifndef QSTEREO_LABELS_H
#define QSTEREO_LABELS_H

#include "coding.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A view: it borrows the file's bytes. A site is undecided where it has
 * variables; all others are fixed at one label. */
typedef struct qs_labels {
    /* From labl: */
    qs_encoding encoding;
    qs_pairwise pairwise; /* table: NULL, the blocks hold it */
    qs_penalty penalty;
    uint32_t labels, scale, gap;
    int32_t weight; /* of every edge; -1 = the weights differ */
    uint32_t width, height; /* of the grid; 0 = none */
    qs_frame frame;
    const uint8_t *mask; /* a bit for each cell as in the file; NULL = every
                            cell is a site */
    qs_meaning meaning; /* from mean; zero = disparities */
    /* From kept: */
    uint32_t sites; /* of the whole problem */
    uint32_t undecided; /* how many of them have variables */
    unsigned fixed_bytes; /* 0 = all sites are undecided and have all labels;
                             else 1 or 2 */
    const uint8_t *fixed; /* of each site, in fixed_bytes: the label that it is
                             fixed at; all bits 1 = it is undecided */
    const uint8_t *sets; /* of each undecided site ceil(labels / 8) bytes: label
                            d is left where bit d % 8 of byte d / 8 is 1 */
    /* From trnc: */
    unsigned trimmed_bytes; /* 0 = no cost was truncated; else 1, 2 or 4 */
    const uint8_t *trimmed; /* of each label left to each undecided site: what
                               truncation took from its cost */
} qs_labels;

#ifdef __cplusplus
}
#endif

#endif
