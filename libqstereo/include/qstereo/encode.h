/* A labelling problem as the bytes of a .qcf: the QUBO H whose minimum is the problem's. */
#ifndef QSTEREO_ENCODE_H
#define QSTEREO_ENCODE_H

#include "problem.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One variable x_pd a site p and label d, exactly one of a site's at 1. The values are those of the file. */
typedef enum qs_encoding {
    QS_ENCODING_DEFAULT = 0, /* one-hot-sparse for Potts, else one-hot */
    /* Heidari, Dinneen and Delmas, eq. (5): weight * sum_{d1,d2} V(d1, d2) x_p,d1 x_q,d2 an edge, k (k - 1) terms for Potts. */
    QS_ONE_HOT = 1,
    /* weight * (1 - sum_d x_pd x_qd) an edge: the same on every labelling in k terms. Potts only. */
    QS_ONE_HOT_SPARSE = 2
} qs_encoding;

/* The one-hot penalty a (1 - S) + b S (S - 1) / 2 of each site, S = the number of its variables at 1. W is the most that the
 * site's edges can cost: max_d sum_q max_l weight_pq V_pq(d, l); for Potts the sum of their weights. */
typedef enum qs_penalty {
    /* The least proven for each site (docs/MATHS.md): one-hot a = W + gap, b = a + gap; one-hot-sparse a = gap,
     * b = a + W + gap. Every infeasible state lies at least `gap` above the minimum and can be improved by one flip. */
    QS_PENALTY_LOCAL = 0,
    /* The paper's one alpha for all: the least integer above sum_p max_d theta_p(d) + sum_pq weight_pq max V, of the costs as
     * they are (not shifted); a = alpha, b = 2 alpha. */
    QS_PENALTY_PAPER = 1,
    QS_PENALTY_GIVEN = 2 /* a = alpha, b = 2 alpha with the caller's alpha; nothing is proven of it */
} qs_penalty;

/* All zero = the defaults. */
typedef struct qs_encode_options {
    qs_encoding encoding;
    qs_penalty penalty;
    int64_t alpha; /* QS_PENALTY_GIVEN only: above 0, in integer units */
    uint32_t gap;  /* QS_PENALTY_LOCAL only: integer units, up to 2^31 - 1; 0 = 1 */
} qs_encode_options;

/* Bytes of workspace for qs_encode: a row of costs and some more, whatever the number of rows. */
size_t qs_encode_workspace(const qs_problem *problem);

/* Writes the problem as a .qcf (docs/FORMAT.md) in one pass, without seeking. Each site's costs are written less their
 * minimum. The costs are gone through once; once more where their largest decides the width, or the paper's alpha.
 *
 * sink  NULL = nothing is written: a sizing pass, which does not see an overflow by the offset
 * size  out, may be NULL: bytes of the file
 * Returns QS_OK; QS_E_ARGUMENT; QS_E_LIMIT; QS_E_ENCODING (one-hot-sparse for a pairwise cost that is not Potts); QS_E_WORKSPACE;
 * QS_E_OVERFLOW (the terms' absolute values sum to over 2^53, or a site's costs lie further apart than 2^32 - 1); QS_E_IO. After
 * QS_E_OVERFLOW or QS_E_IO the sink may have taken a part of the file. */
QS_MUST_CHECK qs_status qs_encode(const qs_problem *problem, const qs_encode_options *options, const qs_sink *sink,
                                  void *workspace, size_t workspace_size, uint64_t *size);

#ifdef __cplusplus
}
#endif

#endif
