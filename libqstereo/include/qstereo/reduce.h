/* Labels that are proven to be in no optimum leave the problem; what is left
 * has the same optima. */
#ifndef QSTEREO_REDUCE_H
#define QSTEREO_REDUCE_H

#include "solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How far a reduction is, and what it found. */
typedef struct qs_reduction {
    int64_t upper_bound; /* energy of the labelling, the best one known */
    int64_t lower_bound; /* of all labellings; equal to the upper bound = proven
                            optimal */
    uint64_t iterations; /* of TRW-S */
    uint64_t variables; /* left, in the encoding asked for: those of the open
                           sites */
    uint32_t open; /* sites with two labels or more left; masked cells are never
                      open */
} qs_reduction;

/* Told after every iteration; returns false to stop: what has been proven until
 * then stays. */
typedef bool qs_reduce_watch(void *context, const qs_reduction *so_far);

/* All zero = go on until the best labelling is proven. */
typedef struct qs_reduce_options {
    uint64_t iterations; /* of TRW-S, at most; 0 = 2000 */
    uint64_t target; /* stop at the first problem of at most this many
                        variables; 0 = none */
    bool walls; /* a site with n labels counts n - 1 variables (domain walls);
                   else n. A site of one label has none */
    qs_reduce_watch *watch;
    void *context;
} qs_reduce_options;

/* Bytes of workspace for qs_reduce. */
size_t qs_reduce_workspace(const qs_model *model);

/* Eliminates labels by Goldstein's criterion (Potts) and by the reduced costs
 * of TRW-S's chains against the best labelling known (docs/MATHS.md): no label
 * that is eliminated is in any optimum. The bound and the labelling are those
 * of qs_best, with the eliminated labels out of the way. Deterministic.
 *
 * model      a file that is reduced already brings its own label sets,
 * model->kept options    NULL = all zero kept       out: sites x labels, 1 =
 * the label is still there, 0 = it is in no optimum; every site keeps one or
 * more. Of masked cells label 0 alone is kept labelling  out: the best
 * labelling found; its labels are kept Returns QS_OK (also when stopped),
 * QS_E_ARGUMENT, QS_E_WORKSPACE. Where costs are too large for the messages'
 * arithmetic there is no bound (QS_NO_BOUND), and Goldstein's criterion alone
 * eliminates. */
QS_MUST_CHECK qs_status qs_reduce(const qs_model *model,
                                  const qs_reduce_options *options,
                                  void *workspace, size_t workspace_size,
                                  uint8_t *kept, uint16_t *labelling,
                                  qs_reduction *reduction);

#ifdef __cplusplus
}
#endif

#endif
