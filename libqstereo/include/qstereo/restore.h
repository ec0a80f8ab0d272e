/* Restoration and inpainting as a labelling problem: the sites are the pixels
 * of a noisy grey picture, the labels are greys. */
#ifndef QSTEREO_RESTORE_H
#define QSTEREO_RESTORE_H

#include "image.h"
#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The unary cost of grey v at a pixel of grey I. Both and the pairwise costs
 * that go with them are those of Szeliski et al., "A comparative study of
 * energy minimization methods for Markov random fields with smoothness-based
 * priors", PAMI 30(6), 2008, section 4 (there: squared). */
typedef enum qs_restore_cost {
    QS_RESTORE_ABSOLUTE =
        0, /* |I - v|: for impulses, such as salt and pepper */
    QS_RESTORE_SQUARED = 1 /* (I - v)^2: for Gaussian noise */
} qs_restore_cost;

/* A noisy picture. Borrows all that it points to. */
typedef struct qs_restore {
    qs_image noisy;
    /* width x height bytes, row after row without gaps: not 0 = the pixel is in
     * a hole, where no grey costs anything. NULL = there is no hole. */
    const uint8_t *hole;
    qs_restore_cost cost;
    uint32_t step; /* labels stand for the greys 0, step, 2 step, ... up to 255;
                      1 .. 255 */
    uint32_t scale; /* integer units in one grey level, or squared grey level;
                       1 .. 2^31 / 65536 */
    int32_t weight; /* of every edge: lambda * scale, at least 0 */
    qs_pairwise pairwise; /* of labels, not of greys: |a - b| counts steps */
} qs_restore;

/* Bytes of workspace for qs_restore_problem, whatever the size of the
 * picture. */
size_t qs_restore_workspace(void);

/* Makes the problem of a picture.
 *
 * restore    copied; what it points to stays borrowed as long as the problem is
 *            used
 * workspace  qs_restore_workspace bytes, aligned for any type; stays borrowed
 * problem    out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, or a value out of range
 *   QS_E_WORKSPACE
 *   QS_E_LIMIT     more variables than QS_VARIABLES_MAX */
QS_MUST_CHECK qs_status qs_restore_problem(const qs_restore *restore,
                                           void *workspace,
                                           size_t workspace_size,
                                           qs_problem *problem);

#ifdef __cplusplus
}
#endif

#endif
