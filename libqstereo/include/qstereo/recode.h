/* A problem that has been laid out for the solvers, written again: in any
 * encoding, over the labels that are left, with smaller coefficients. */
#ifndef QSTEREO_RECODE_H
#define QSTEREO_RECODE_H

#include "model.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* All zero = the defaults of qs_encode. */
typedef struct qs_recode_options {
    qs_encode_options encode;
    /* Costs above what the site's edges can cost are cut to one above it: the
     * optima stay, and what was cut is noted in the file (docs/FORMAT.md,
     * trnc). */
    bool truncate;
    /* sites x labels of the model, 0 = the label is left out; NULL = those of
     * model->kept. A site with one label left is fixed: its costs go into the
     * offset and into its neighbours' linear terms, its edges vanish and the
     * neighbours' penalties shrink. */
    const uint8_t *kept;
} qs_recode_options;

/* Bytes of workspace for qs_recode. */
size_t qs_recode_workspace(const qs_model *model,
                           const qs_recode_options *options);

/* Writes a .qcf (docs/FORMAT.md). F of every labelling of the labels left is
 * the model's; the sites are those of the problem.
 *
 * labels  what the problem's labels mean: from qs_model_of_problem, or those of
 *         the file that the model was built from (qs_qubo, labels). Its
 *         encoding, penalty and gap are not looked at: the options say these
 * sink    NULL = nothing is written: a sizing pass
 * size    out, may be NULL: bytes of the file
 *
 * Returns
 * QS_OK
 * QS_E_ARGUMENT   a null pointer, an option out of range, or a site without a
 *                 label
 * QS_E_ENCODING   the encoding cannot hold this pairwise cost, or has no such
 *                 penalty
 * QS_E_LIMIT      over QS_VARIABLES_MAX variables or couplings
 * QS_E_WORKSPACE
 * QS_E_OVERFLOW   as qs_encode; and in the encodings that models are built from
 *                 a cost that a model does not hold: with what fixed neighbours
 *                 add it is above 2^31 - 1
 * QS_E_IO         the sink refused bytes */
QS_MUST_CHECK qs_status qs_recode(const qs_model *model,
                                  const qs_labels *labels,
                                  const qs_recode_options *options,
                                  const qs_sink *sink, void *workspace,
                                  size_t workspace_size, uint64_t *size);

#ifdef __cplusplus
}
#endif

#endif
