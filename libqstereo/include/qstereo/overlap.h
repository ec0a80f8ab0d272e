/* Choosing among overlapping detections as a labelling problem: the sites are
 * boxes, the labels are 0, drop, and 1, keep. */
#ifndef QSTEREO_OVERLAP_H
#define QSTEREO_OVERLAP_H

#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { QS_BOX_PLACE_MAX = 1 << 26, QS_BOX_SCORE_MAX = 1 << 30 };

/* A box, in any unit of length. x, y: its left upper corner, at most
 * QS_BOX_PLACE_MAX from 0; width and height 1 .. QS_BOX_PLACE_MAX. */
typedef struct qs_box {
    uint32_t picture; /* boxes of different pictures do not overlap */
    int32_t x, y, width, height;
    int32_t score; /* round(100 score), at most QS_BOX_SCORE_MAX from 0 */
} qs_box;

/* Makes the problem of which boxes to keep:
 *
 *     theta_p(keep)    = -round(100 score_p),      theta_p(drop) = 0
 *     V_pq(keep, keep) = round(400 IoU(p, q))      where IoU(p, q) > 0.1,
 *
 * else 0; IoU is the area that two boxes share over the area that they cover.
 * (Non-maximum suppression as a quadratic binary problem, as in Rujikietgumjorn
 * and Collins, "Optimized pedestrian detection for multiple and occluded
 * people", CVPR 2013, and Li and Ghosh, "Quantum-soft QUBO suppression", ECCV
 * 2020.) The scale is 100: energies are in units of the score.
 *
 * boxes      borrowed for the call only
 * workspace  qs_overlap_workspace bytes, aligned for any type; stays borrowed
 *            as long as the problem is used
 * problem    out: a list of edges with one table for all; the edges are in
 *            order
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, no box, or a box out of range
 *   QS_E_WORKSPACE
 *   QS_E_LIMIT     more variables or edges than QS_VARIABLES_MAX */
QS_MUST_CHECK qs_status qs_overlap_problem(const qs_box *boxes, uint32_t count,
                                           void *workspace,
                                           size_t workspace_size,
                                           qs_problem *problem);

/* Bytes of workspace for qs_overlap_problem: costs and edges. SIZE_MAX = more
 * than this machine can address, no box, or a box out of range. */
size_t qs_overlap_workspace(const qs_box *boxes, uint32_t count);

#ifdef __cplusplus
}
#endif

#endif
