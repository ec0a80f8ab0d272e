/* Stereo matching with costs, labels and weights beyond those of the paper: the
 * sites are the pixels of the left picture, the labels are disparities of whole
 * or half pixels. For absolute differences of whole pixels alone, stereo.h is
 * quicker and smaller. */
#ifndef QSTEREO_MATCHING_H
#define QSTEREO_MATCHING_H

#include "image.h"
#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a pixel (x, y) costs with disparity d: a number that two samples differ
 * by, l of the left picture at x and r of the right one at x - d. All are whole
 * numbers. A sample of the right picture between two pixels is (R[x - 1] + R[x]
 * + 1) / 2, rounded down. */
typedef enum qs_match_cost {
    QS_MATCH_AD = 0, /* |l - r|, in greys: 0 .. 255 */
    QS_MATCH_SD = 1, /* (l - r)^2, in squared greys: 0 .. 65025 */
    QS_MATCH_BT = 2, /* in half greys, 0 .. 510: by how much twice a sample
        leaves the range that the other picture has within half a pixel,

            range of I at x: from the least to the largest of
                             2 I[x], I[x] + I[x - 1], I[x] + I[x + 1]
            cost: the smaller one of how far 2 l is from the range of the right
                  picture, and 2 r from that of the left one

        (Birchfield and Tomasi 1998, in whole numbers) */
    QS_MATCH_CENSUS = 3 /* how many of the pixels q of a window differ in
        [I(q) < I(p)], p its centre: 0 .. width * height - 1 (Zabih and Woodfill
        1994). Outside a picture its nearest pixel counts */
} qs_match_cost;

/* weight * min(cost, truncation). */
typedef struct qs_match_term {
    qs_match_cost cost;
    uint32_t weight; /* 1 .. 255 */
    uint32_t truncation; /* 0 = none */
    uint32_t width, height; /* of the window of census: 1, 3, 5 or 7, together
                               more than one pixel; else 0 */
} qs_match_term;

enum { QS_MATCH_TERMS = 2, QS_MATCH_COPIES = 16 };

/* What becomes of pixels some of whose matches lie outside the right
 * picture. */
typedef enum qs_border {
    QS_BORDER_LEAVE_OUT = 0, /* the grid begins behind them, as in the paper */
    QS_BORDER_KEEP = 1 /* such a match costs as much as the truncation of the
                          first term, times its weight; the others as usual. So
                          the smoothness decides there */
} qs_border;

/* A rectified pair, and the window of the left picture that is to be matched.
 * Borrows the pictures. */
typedef struct qs_matching {
    qs_image left, right; /* of the same size */
    qs_match_term terms[QS_MATCH_TERMS]; /* theta is their sum */
    unsigned term_count; /* 1 .. QS_MATCH_TERMS */
    uint32_t parts; /* labels in a pixel: 1 or 2 */
    int32_t disparity_min, disparity_max; /* both included, in parts; above
                                             -2^31 */
    qs_border border; /* QS_BORDER_KEEP needs a truncation of the first term */
    uint32_t x, y, width, height; /* the window; width 0 = the whole picture */
    uint32_t scale; /* integer units in one unit of theta, at least 1 */
    int32_t weight; /* lambda * scale, at least 0 */
    /* An edge between pixels whose greys in the left picture differ by less
     * than `contrast_below` has the weight contrast_times * weight (Boykov,
     * Veksler and Zabih 2001, section 8.2). 0 = every edge has `weight`. */
    uint32_t contrast_below; /* in greys, 0 .. 256 */
    uint32_t contrast_times; /* at least 1 where contrast_below is not 0 */
    /* Rows of costs that are computed at the same time, at most
     * QS_MATCH_COPIES; 0 = one. */
    uint32_t copies;
} qs_matching;

/* The largest theta that the terms can have, without `scale`; 0 if a term is
 * not as above. At most 65535 is allowed. */
uint32_t qs_matching_most(const qs_matching *matching);

/* Makes the problem of a pair. Its pairwise cost is Potts; it may be changed
 * afterwards. Its costs have one byte where scale is 1 and theta is below 256.
 * frame.first is in parts of a pixel, and meaning.unit says which.
 *
 * matching   copied; the pixels stay borrowed as long as the problem is used
 * workspace  at least qs_matching_workspace bytes, aligned for any type; stays
 *            borrowed like the pixels. So only one thread at a time may use the
 *            problem, or as many as there are copies, as problem.h says
 * problem    out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a value out of range
 *   QS_E_WORKSPACE
 *   QS_E_LIMIT     more than QS_LABELS_MAX disparities, or more variables than
 *                  QS_VARIABLES_MAX
 *   QS_E_OVERFLOW  a cost or a weight is above 2^31 - 1
 *   QS_E_GEOMETRY  the sizes of the pictures differ, the window leaves the
 *                  picture, or none of its pixels is left */
QS_MUST_CHECK qs_status qs_matching_problem(const qs_matching *matching,
                                            void *workspace,
                                            size_t workspace_size,
                                            qs_problem *problem);

/* Bytes of workspace for qs_matching_problem: some rows of the pictures, the
 * costs of a few dozen pixels, and, with contrast, the weights of all edges.
 * SIZE_MAX if no workspace can be so large. */
size_t qs_matching_workspace(const qs_matching *matching);

#ifdef __cplusplus
}
#endif

#endif
