/* Writes a model as a QUBO again: in any encoding, over the labels that are
 * left, with smaller coefficients. */
#ifndef QSTEREO_RECODE_H
#define QSTEREO_RECODE_H

#include "model.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* All zero = the defaults. */
typedef struct qs_recode_options {
    qs_encode_options encode;
    /* Truncate costs: a label that costs over one more than all the edges of
     * its site can cost is brought down to that. The optima stay. What is taken
     * from the costs is noted in the file (docs/FORMAT.md, trnc). */
    bool truncate;
    /* sites x labels of the model, 0 = the label is left out; NULL =
     * model->kept. A site with one label left is fixed: its costs go into the
     * offset and into the linear terms of its neighbours, its edges vanish, and
     * the neighbours' penalties shrink. */
    const uint8_t *kept;
    /* The best labelling known, labels of the problem's sites, and a lower
     * bound of all labellings, in integer units (QS_NO_BOUND = none). The file
     * carries both (docs/FORMAT.md, best) if it has variables and its encoding
     * is one-hot, one-hot-sparse or domain-wall. NULL = it carries neither. */
    const uint16_t *best;
    int64_t lower_bound;
} qs_recode_options;

/* Bytes of workspace for qs_recode. */
size_t qs_recode_workspace(const qs_model *model,
                           const qs_recode_options *options);

/* Writes a .qcf (docs/FORMAT.md). The sites are those of the problem. Each
 * labelling of the labels left has the energy F that the model gives it.
 *
 * labels     what the labels of the problem mean: from qs_model_of_problem, or
 *            those of the file that the model was built from (qubo->labels).
 *            Its encoding, penalty and gap do not count: the options say these
 * sink       NULL = nothing is written: a sizing pass
 * workspace  qs_recode_workspace bytes, aligned for any type
 * size       out, may be NULL: bytes of the file
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT   a null pointer, an option out of its range, a site without
 *                   a label, or one whose best label is left out
 *   QS_E_ENCODING   the encoding cannot hold this pairwise cost, or does not
 *                   have this penalty for it
 *   QS_E_LIMIT      over QS_VARIABLES_MAX variables or couplings
 *   QS_E_WORKSPACE  the workspace is too small
 *   QS_E_OVERFLOW   as qs_encode. In the encodings that models are built from
 *                   also a cost, with what fixed neighbours add to it, above
 *                   2^31 - 1
 *   QS_E_IO         the sink refused bytes */
QS_MUST_CHECK qs_status qs_recode(const qs_model *model,
                                  const qs_labels *labels,
                                  const qs_recode_options *options,
                                  const qs_sink *sink, void *workspace,
                                  size_t workspace_size, uint64_t *size);

#ifdef __cplusplus
}
#endif

#endif
