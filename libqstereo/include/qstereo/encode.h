/* A labelling problem as the bytes of a .qcf: the QUBO H whose minimum is the
 * problem's. */
#ifndef QSTEREO_ENCODE_H
#define QSTEREO_ENCODE_H

#include "coding.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of workspace for qs_encode: a row of costs and some more, whatever the
 * number of rows. */
size_t qs_encode_workspace(const qs_problem *problem);

/* Writes the problem as a .qcf (docs/FORMAT.md) in one pass, without seeking,
 * in the encoding one-hot or one-hot-sparse; recode.h makes the others of such
 * a file. Each site's costs are written less their minimum. The costs are gone
 * through once; once more where their largest decides the width, or the paper's
 * alpha.
 *
 * sink  NULL = nothing is written: a sizing pass, which does not see an
 * overflow by the offset size  out, may be NULL: bytes of the file Returns
 * QS_OK; QS_E_ARGUMENT; QS_E_LIMIT; QS_E_ENCODING (not one of the two;
 * one-hot-sparse for a quadratic cost or a table, or with the paper's alpha for
 * a linear one); QS_E_WORKSPACE; QS_E_OVERFLOW (the terms' absolute values sum
 * to over 2^53, or a site's costs lie further apart than 2^32 - 1); QS_E_IO.
 * After QS_E_OVERFLOW or QS_E_IO the sink may have taken a part of the file. */
QS_MUST_CHECK qs_status qs_encode(const qs_problem *problem,
                                  const qs_encode_options *options,
                                  const qs_sink *sink, void *workspace,
                                  size_t workspace_size, uint64_t *size);

#ifdef __cplusplus
}
#endif

#endif
