/* Writes a labelling problem as a .qcf: the QUBO H whose minimum is that of the
 * problem's energy F. */
#ifndef QSTEREO_ENCODE_H
#define QSTEREO_ENCODE_H

#include "coding.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of workspace for qs_encode: a row of costs and a little more, whatever
 * the number of rows. */
size_t qs_encode_workspace(const qs_problem *problem);

/* Writes the problem as a .qcf (docs/FORMAT.md) in one pass, without seeking,
 * in the encoding one-hot or one-hot-sparse; qs_recode writes it in the others.
 * Each site's costs are written less the least of them. The costs are read
 * once; and once more before that, if their number of bytes or the paper's
 * alpha depends on the largest.
 *
 * options    all zero = the defaults
 * sink       NULL = nothing is written: a sizing pass. It does not notice an
 *            overflow of the offset
 * workspace  qs_encode_workspace bytes, aligned for any type
 * size       out, may be NULL: bytes of the file
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT   the problem or the options are not as their comments say
 *   QS_E_LIMIT      over QS_VARIABLES_MAX variables or edges
 *   QS_E_ENCODING   another encoding, or a label is forbidden (qs_recode writes
 *                   such problems); or one-hot-sparse of a quadratic cost or
 *                   tables, or with the paper's alpha for a linear cost; or
 *                   tables of edges where the library is built with QS_SMALL
 *   QS_E_WORKSPACE  the workspace is too small
 *   QS_E_OVERFLOW   the absolute values of all terms sum up to more than
 *                   QS_ENERGY_MAX, or two costs of a site differ by more than
 *                   2^32 - 1
 *   QS_E_IO         the sink refused bytes
 * After QS_E_OVERFLOW and QS_E_IO the sink may have taken a part of the
 * file. */
QS_MUST_CHECK qs_status qs_encode(const qs_problem *problem,
                                  const qs_encode_options *options,
                                  const qs_sink *sink, void *workspace,
                                  size_t workspace_size, uint64_t *size);

#ifdef __cplusplus
}
#endif

#endif
