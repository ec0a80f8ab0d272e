/* Stereo matching as a labelling problem: a site a pixel of the left picture, a
 * label a disparity. */
#ifndef QSTEREO_STEREO_H
#define QSTEREO_STEREO_H

#include "image.h"
#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Unary costs theta of pixel (x, y) and disparity d. */
typedef enum qs_cost {
    QS_COST_AD = 0 /* |Il(x, y) - Ir(x - d, y)|, the paper's eq. (3) */
} qs_cost;

/* A rectified pair and the window of the left picture to be matched. Borrows
 * the pictures. */
typedef struct qs_stereo {
    qs_image left, right;
    qs_cost cost;
    uint32_t disparity_min, disparity_max; /* pixels, both included */
    uint32_t x, y, width,
        height; /* window in the left picture; width 0 = the whole picture */
    uint32_t scale; /* integer units in one unit of grey, 1 .. 2^31 / 256 */
    int32_t weight; /* lambda * scale, at least 0 */
} qs_stereo;

/* Makes the Potts problem of a pair; its smoothness may be changed afterwards.
 * Pixels of the window with a candidate match outside the right picture are
 * left out (the paper leaves out the first d_max columns): the grid is the rest
 * of the window, its place in the left picture is in problem->frame.
 *
 * stereo     copied; the pictures' pixels are borrowed for as long as the
 * problem is used workspace  borrowed likewise, at least qs_stereo_workspace
 * bytes, aligned for any type; a problem is used by one thread at a time
 * problem    out
 * Returns QS_OK; QS_E_ARGUMENT; QS_E_WORKSPACE; QS_E_LIMIT (over QS_LABELS_MAX
 * disparities, or QS_VARIABLES_MAX variables); QS_E_GEOMETRY: the pictures'
 * sizes differ, the window is not inside them, or none of its pixels is left.
 */
QS_MUST_CHECK qs_status qs_stereo_problem(const qs_stereo *stereo,
                                          void *workspace,
                                          size_t workspace_size,
                                          qs_problem *problem);

/* Bytes of workspace of qs_stereo_problem, whatever the number of rows: the
 * costs of a few dozen pixels. */
size_t qs_stereo_workspace(const qs_stereo *stereo);

#ifdef __cplusplus
}
#endif

#endif
