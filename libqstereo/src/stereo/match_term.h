/* The costs of a term for a tile of pixels and one label, each loop on small numbers that a
 * compiler makes vectors of. */
#ifndef QS_MATCH_TERM_H
#define QS_MATCH_TERM_H

#include "match_row.h"

enum { QS_MATCH_TILE = 64 };

/* Adds weight * min(cost, truncation) to each sum. The second one does the same by AVX2.
 *
 * left, right  where the tile begins in the arrays of the rows */
void qs_match_term_add(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                       const qs_match_row *right_row, size_t right, uint16_t sum[QS_MATCH_TILE]);
void qs_match_term_add_avx2(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                            const qs_match_row *right_row, size_t right,
                            uint16_t sum[QS_MATCH_TILE]);

/* Where the match of a pixel is: in which row, and at which element of its arrays. */
typedef struct qs_match_place {
    uint32_t part, at;
} qs_match_place;

/* The same for pixels one after the other, each with a match of its own.
 *
 * left        where the pixels begin in the arrays of their row; its words have been made
 * right_rows  so have theirs
 * sum         of each pixel */
void qs_match_term_pick(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                        const qs_match_row right_rows[], const qs_match_place *places,
                        uint32_t count, uint32_t *sum);

/* The largest cost that a term can have, without weight and truncation. */
uint32_t qs_match_term_most(const qs_match_term *term);

#endif
