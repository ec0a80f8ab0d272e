/* What the labels of a problem stand for, so that whoever reads a .qcf knows
 * what to make of a labelling. No energy depends on it. */
#ifndef QSTEREO_MEANING_H
#define QSTEREO_MEANING_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Label j stands for ... The values are those of the file. */
typedef enum qs_meaning_kind {
    QS_MEANS_DISPARITY = 0, /* a disparity of frame.first + j pixels, or, where
                               unit is not 0, of (frame.first + j) / unit */
    QS_MEANS_NUMBER = 1, /* the number j itself */
    QS_MEANS_GREY = 2, /* the grey j * step */
    QS_MEANS_CLASS = 3, /* class frame.first + j */
    QS_MEANS_DISPLACEMENT = 4, /* see below */
    QS_MEANS_KEEP = 5 /* 0 drop, 1 keep */
} qs_meaning_kind;

#define QS_MEANING_KINDS 6 /* kinds 0 .. QS_MEANING_KINDS - 1 */

/* Zero = disparities in whole pixels. A displacement is
 *
 *     dx = (x + j % columns) / unit,  dy = (y + j / columns) / unit  pixels,
 *
 * and cell (i, k) of the grid stands at pixel (i * step, k * step) of the
 * picture. The last column and row of cells may stand beyond its border. */
typedef struct qs_meaning {
    qs_meaning_kind kind;
    uint32_t step; /* grey: between labels, displacement: pixels between cells;
                      1 .. 65535. Else 0 */
    uint32_t columns; /* of displacements 1 .. 65535, else 0 */
    uint32_t unit; /* parts of a pixel: of displacements 1 .. 65535, of
                      disparities 2 .. 65535 or 0 = whole pixels. Else 0 */
    /* Of displacements, else 0: */
    int32_t x, y; /* of label 0, in parts of a pixel, -2^24 .. 2^24 */
} qs_meaning;

/* Returns true if all is as the comments above say. */
bool qs_meaning_is_valid(const qs_meaning *meaning);

#ifdef __cplusplus
}
#endif

#endif
