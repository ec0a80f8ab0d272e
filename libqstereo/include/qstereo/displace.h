/* Optical flow and registration as one labelling problem: where did each place
 * of the first picture go in the second one? The sites are pixels of the first
 * picture, `step` apart; the labels are displacements in two dimensions. */
#ifndef QSTEREO_DISPLACE_H
#define QSTEREO_DISPLACE_H

#include "image.h"
#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Two pictures of one size. With p the pixel of a site, d a displacement, and a
 * square B of `window` x `window` pixels around the origin:
 *
 *     theta_p(d)  = mean over b in B of |first(p + b) - second(p + b + d)|
 *     V(d, e)     = min(|d.x - e.x| + |d.y - e.y|, truncation)
 *
 * Beyond its border a picture continues with the pixels of the border; between
 * pixels it is interpolated bilinearly. Every edge has the weight lambda; theta
 * is in grey levels, V in pixels.
 *
 * (Glocker, Komodakis, Tziritas, Navab and Paragios, "Dense image registration
 * through MRFs and efficient linear programming", Medical Image Analysis 12,
 * 2008: labels, control points and the truncated difference of displacements,
 * section 3; here a box stands for the spline's weights.)
 *
 * To stay within integers, one grey level is
 *
 *     window^2 * unit^2 * scale
 *
 * units, the scale of the problem, and lambda * scale must be an integer. */
typedef struct qs_displace {
    qs_image first, second;
    uint32_t step; /* pixels between sites, 1 .. 65535 */
    uint32_t window; /* odd, 1 .. 255 */
    /* The largest displacements, in 1 / unit pixel. There are
     * (2 radius_x + 1) (2 radius_y + 1) labels. */
    uint32_t radius_x, radius_y;
    uint32_t unit; /* displacements are multiples of 1 / unit pixel, 1 .. 16 */
    uint32_t scale; /* as above, at least 1 */
    int32_t weight; /* lambda * scale, at least 0 */
    uint32_t truncation; /* of V, in 1 / unit pixel; 0 = none */
} qs_displace;

/* Bytes of workspace for qs_displace_problem: the table V, and the sums of one
 * row. SIZE_MAX = more than this machine can address. */
size_t qs_displace_workspace(const qs_displace *displace);

/* Makes the problem. Its meaning says where sites stand and which displacement
 * each label is.
 *
 * displace   copied; the pixels stay borrowed as long as the problem is used
 * workspace  qs_displace_workspace bytes, aligned for any type; stays borrowed
 * problem    out. Only one thread at a time may use it
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a value out of range
 *   QS_E_WORKSPACE
 *   QS_E_LIMIT     more than QS_LABELS_MAX labels, or more variables than
 *                  QS_VARIABLES_MAX
 *   QS_E_GEOMETRY  the sizes of the pictures differ
 *   QS_E_OVERFLOW  a cost may be above 2^31 - 1 units */
QS_MUST_CHECK qs_status qs_displace_problem(const qs_displace *displace,
                                            void *workspace,
                                            size_t workspace_size,
                                            qs_problem *problem);

/* The displacement of every pixel of a labelling: between sites it is
 * interpolated bilinearly.
 *
 * meaning    of the problem
 * labelling  width x height labels, of the cells of the grid
 * field      out: picture_width x picture_height pairs (dx, dy), in units of
 *            1 / (unit * step^2) pixel
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or the meaning is another one
 *   QS_E_OVERFLOW  a value may be above 2^31 - 1 units */
QS_MUST_CHECK qs_status qs_displace_field(const qs_meaning *meaning,
                                          uint32_t width, uint32_t height,
                                          const uint16_t *labelling,
                                          uint32_t picture_width,
                                          uint32_t picture_height,
                                          int32_t *field);

#ifdef __cplusplus
}
#endif

#endif
