/* Segmentation as a labelling problem: the sites are the pixels of a picture,
 * the labels are classes of which somebody has marked a few pixels. */
#ifndef QSTEREO_SEGMENT_H
#define QSTEREO_SEGMENT_H

#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

#define QS_CLASSES_MAX 255u

/* A photograph and strokes on it, after Boykov and Jolly, "Interactive graph
 * cuts for optimal boundary and region segmentation of objects in N-D images",
 * ICCV 2001. With I the colour of a pixel and P(I | c) the histogram of
 * class c:
 *
 *     theta_p(c)  = -ln P(I_p | c)                              (their eq. (4))
 *     V(a, b)     = 0 if a = b, else 1
 *     weight_pq   = lambda exp(-beta |I_p - I_q|^2),
 *     beta        = 1 / (2 mean over edges of |I_p - I_q|^2)    (their eq. (6);
 *                   beta: Rother, Kolmogorov and Blake, "GrabCut", 2004)
 *
 * At a pixel with a stroke every other class is forbidden. A histogram has 16
 * levels a channel; each pixel of the class counts 16 and each bin gets 1 more,
 * so that no colour is impossible. A class without strokes has the colours of
 * the pixels without strokes: so a box around an object, with strokes of class
 * 1 outside of it, is enough to begin with.
 *
 * Everything is rounded to integers by tables, so that every machine agrees.
 * Borrows all that it points to. */
typedef struct qs_segment {
    const uint8_t
        *photo; /* height rows of `stride` bytes; a pixel is `channels`
                             bytes */
    uint32_t width, height;
    size_t stride; /* at least width * channels */
    unsigned channels; /* 1 or 3 */
    /* width x height bytes, row after row without gaps: 0 = no stroke, v = a
     * stroke of class v. NULL = there are none, and costs are given. */
    const uint8_t *strokes;
    uint32_t classes; /* 2 .. QS_CLASSES_MAX; label j is class j + 1 */
    /* width x height x classes costs in units of 1 / scale instead of those of
     * histograms. NULL = histograms. */
    const int32_t *costs;
    uint32_t scale; /* integer units in one real unit, 1 .. 1000000 */
    int32_t weight; /* lambda * scale, at least 0 */
} qs_segment;

/* Bytes of workspace for qs_segment_problem: the weights of all edges, what is
 * allowed at each pixel, and the histograms. SIZE_MAX = more than this machine
 * can address. */
size_t qs_segment_workspace(const qs_segment *segment);

/* Makes the problem.
 *
 * segment    copied; what it points to stays borrowed as long as the problem is
 *            used
 * workspace  qs_segment_workspace bytes, aligned for any type; stays borrowed
 * problem    out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, a value out of range, or a stroke of a class
 *                  that there is not
 *   QS_E_WORKSPACE
 *   QS_E_LIMIT     more variables than QS_VARIABLES_MAX */
QS_MUST_CHECK qs_status qs_segment_problem(const qs_segment *segment,
                                           void *workspace,
                                           size_t workspace_size,
                                           qs_problem *problem);

/* Counts the histograms again, from a labelling of all pixels; the problem that
 * the workspace belongs to has these costs from now on. A class without pixels
 * keeps its histogram. (Rother, Kolmogorov and Blake 2004, where colour models
 * are mixtures of Gaussians.) Where costs are given, nothing changes.
 *
 * labelling  width x height labels, 0 .. classes - 1
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a label that there is not */
QS_MUST_CHECK qs_status qs_segment_refit(void *workspace,
                                         const uint16_t *labelling);

#ifdef __cplusplus
}
#endif

#endif
