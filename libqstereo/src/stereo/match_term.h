/* The costs of a term for a tile of pixels and one label, each loop on small numbers that a
 * compiler makes vectors of. */
#ifndef QS_MATCH_TERM_H
#define QS_MATCH_TERM_H

#include "match_row.h"

enum { QS_MATCH_TILE = 64 };

/* Adds weight * min(cost, truncation) to each sum.
 *
 * left, right  where the tile begins in the arrays of the rows */
void qs_match_term_add(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                       const qs_match_row *right_row, size_t right, uint16_t sum[QS_MATCH_TILE]);

/* The same for one pixel: returns what is added. */
uint32_t qs_match_term_one(const qs_match_term *term, const qs_match_row *left_row, size_t left,
                           const qs_match_row *right_row, size_t right);

/* The largest cost that a term can have, without weight and truncation. */
uint32_t qs_match_term_most(const qs_match_term *term);

#endif
