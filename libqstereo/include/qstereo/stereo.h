/* Stereo matching as a labelling problem: the sites are the pixels of the left
 * picture, the labels are disparities.
 *
 * The costs here are the paper's, absolute differences, computed in bytes with
 * the code and memory that a camera has. matching.h has all other costs. It can
 * do these too, and gives the same problem, but takes longer. */
#ifndef QSTEREO_STEREO_H
#define QSTEREO_STEREO_H

#include "image.h"
#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The unary cost theta of pixel (x, y) with disparity d. */
typedef enum qs_cost {
    QS_COST_AD = 0 /* |Il(x, y) - Ir(x - d, y)| (Heidari, Dinneen and Delmas,
                      eq. (3)) */
} qs_cost;

/* A rectified pair of pictures, and the window of the left one that is to be
 * matched. Borrows the pictures. */
typedef struct qs_stereo {
    qs_image left, right; /* of the same size */
    qs_cost cost;
    int32_t disparity_min, disparity_max; /* in pixels, both included; above
                                             -2^31. Below 0 the match stands
                                             further right in the right
                                             picture */
    uint32_t x, y, width, height; /* the window; width 0 = the whole picture */
    uint32_t scale; /* integer units in one grey level, 1 .. 2^31 / 256 */
    int32_t weight; /* lambda * scale, at least 0 */
} qs_stereo;

/* Makes the problem of a pair. Its pairwise cost is Potts; it may be changed
 * afterwards.
 *
 * Pixels for which some candidate lies outside the right picture are left out:
 * the grid is the rest of the window. (The paper leaves out the first d_max
 * columns, too. Where disparity_min is below 0, as many of the last columns are
 * left out.) problem->frame says where it lies in the left picture.
 *
 * stereo     copied; the pixels stay borrowed as long as the problem is used
 * workspace  at least qs_stereo_workspace bytes, aligned for any type; stays
 *            borrowed like the pixels. So only one thread at a time may use the
 *            problem
 * problem    out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a value out of range
 *   QS_E_WORKSPACE
 *   QS_E_LIMIT     more than QS_LABELS_MAX disparities, or more variables than
 *                  QS_VARIABLES_MAX
 *   QS_E_GEOMETRY  the sizes of the pictures differ, the window leaves the
 *                  picture, or none of its pixels is left */
QS_MUST_CHECK qs_status qs_stereo_problem(const qs_stereo *stereo,
                                          void *workspace,
                                          size_t workspace_size,
                                          qs_problem *problem);

/* Bytes of workspace for qs_stereo_problem: the costs of a few dozen pixels,
 * whatever the size of the pictures. */
size_t qs_stereo_workspace(const qs_stereo *stereo);

#ifdef __cplusplus
}
#endif

#endif
