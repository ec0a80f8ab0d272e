/* Labels that are proven to be in no optimum leave the problem. What is left
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
    int64_t lower_bound; /* of all labellings; equal to the upper bound = the
                            labelling is proven optimal */
    uint64_t iterations; /* of TRW-S */
    uint64_t variables; /* of the undecided sites, in the encoding asked for */
    uint32_t undecided; /* sites with two labels or more left; a masked cell
                           never is */
} qs_reduction;

/* Called after every iteration, and now and then within it and before the first
 * one. Returns false to stop: what has been proven until then stays. */
typedef bool qs_reduce_watch(void *context, const qs_reduction *so_far);

enum { QS_REDUCE_ITERATIONS = 2000 };

/* All zero = go on until the best labelling is proven. */
typedef struct qs_reduce_options {
    uint64_t iterations; /* of TRW-S, at most; 0 = QS_REDUCE_ITERATIONS.
                            Without a target it ends before where half of them,
                            512 or more, have gained nothing */
    uint64_t target; /* stop at the first problem of at most this many
                        variables; 0 = none */
    bool walls; /* a site with n labels counts n - 1 variables (domain walls);
                   else n. A site of one label has none */
    qs_reduce_watch *watch; /* NULL = nobody */
    void *context; /* of watch */
    const uint16_t *start; /* labels of the model's sites to begin with; the
                              result is not above them. NULL = none */
    /* NULL = nobody. With one, parts are not solved, nor windows searched:
     * their proof is none of shares */
    const qs_witness *witness;
} qs_reduce_options;

/* Bytes of workspace for qs_reduce. */
size_t qs_reduce_workspace(const qs_model *model);

/* Takes out labels by Goldstein's criterion and by the marginals of TRW-S's
 * chains, against the best labelling known (docs/MATHS.md). No label that goes
 * is in any optimum. Parts of the problem that stay open, and are small enough,
 * are solved by branch and bound and by elimination, and windows of a large
 * grid are searched, unless there is a target. Bound and labelling are found as
 * by qs_best, without the labels that have gone. The same arguments give the
 * same answer on every machine.
 *
 * model      of a file that is reduced already it brings label sets, kept
 * options    NULL = all zero
 * workspace  aligned for any type
 * kept       out: sites x labels, 1 = the label is still there, 0 = it is in no
 *            optimum. Every site keeps one or more; a masked cell keeps label 0
 * labelling  out: the best labelling found; its labels are kept
 * reduction  out
 *
 * Returns
 *   QS_OK          also when stopped
 *   QS_E_ARGUMENT  a null pointer, or a start with a label that there is not
 *   QS_E_WORKSPACE */
QS_MUST_CHECK qs_status qs_reduce(const qs_model *model,
                                  const qs_reduce_options *options,
                                  void *workspace, size_t workspace_size,
                                  uint8_t *kept, uint16_t *labelling,
                                  qs_reduction *reduction);

#ifdef __cplusplus
}
#endif

#endif
