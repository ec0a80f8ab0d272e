/* One row of a picture, as the costs of matching need it: the samples, their ranges, and the census
 * of each. */
#ifndef QS_MATCH_ROW_H
#define QS_MATCH_ROW_H

#include "../../include/qstereo/matching.h"
#include "../base/arena.h"

enum {
    QS_CENSUS_REACH = 3, /* of the largest window */
    QS_CENSUS_ROWS = 2 * QS_CENSUS_REACH + 1,
    QS_CENSUS_BYTES = 6 /* of the largest window: 48 bits */
};

/* Which parts of a row the terms need, and with what. */
typedef struct qs_match_needs {
    bool wide; /* the processor has AVX2 */
    bool range, census;
    uint32_t width, height; /* of the window of census */
} qs_match_needs;

/* Element pad + x of each array belongs to sample x of the row; there is room for `pad` elements
 * before the row and for `behind` after it. */
typedef struct qs_match_row {
    size_t pad, length; /* of the arrays */
    uint8_t *grey;
    int16_t *low, *high; /* the range of the doubled samples; NULL = not needed */
    uint8_t *census[QS_CENSUS_BYTES]; /* bit i of the census is bit i % 8 of byte i / 8 */
    uint64_t *words; /* the bytes of each census in one, after qs_match_row_pack */
    uint8_t *around[QS_CENSUS_ROWS]; /* the rows about this one, with QS_CENSUS_REACH more samples
                                        at both ends */
    size_t next; /* the row that can follow with one more row read; 0 = none */
} qs_match_row;

/* Takes the arrays from an arena. */
qs_match_row qs_match_row_take(qs_arena *arena, const qs_match_needs *needs, size_t width,
                               size_t pad, size_t behind);

/* Fills them in from row y of the picture.
 *
 * between  samples half a pixel to the left of the pixels: sample x is (I[x - 1] + I[x] + 1) / 2 */
void qs_match_row_read(qs_match_row *row, const qs_match_needs *needs, const qs_image *image,
                       size_t y, bool between);

/* Makes the words of a row that has been read, if it has a census. */
void qs_match_row_pack(qs_match_row *row);

#endif
