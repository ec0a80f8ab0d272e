/* A labelling problem as the bytes of a .qcf: the QUBO H whose minimum is the
 * problem's. */
#ifndef QSTEREO_ENCODE_H
#define QSTEREO_ENCODE_H

#include "problem.h"
#include "stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The published ways to write a labelling as bits (docs/MATHS.md). Their
 * variables: docs/FORMAT.md, side chunk labl. The values are those of the file.
 */
typedef enum qs_encoding {
    QS_ENCODING_DEFAULT = 0, /* one-hot-sparse for Potts, else one-hot */
    /* One variable x_pd a site p and label d, exactly one of a site's at 1.
     * Heidari, Dinneen and Delmas, eq. (5): weight * sum_{d1,d2} V(d1, d2)
     * x_p,d1 x_q,d2 an edge, k (k - 1) terms for Potts. Any V. */
    QS_ONE_HOT = 1,
    /* Potts: weight * (1 - sum_d x_pd x_qd) an edge, the same on every
     * labelling in k terms. Linear truncated at T: weight * (T - sum_{|d-e|<T}
     * (T - |d-e|) x_pd x_qe). */
    QS_ONE_HOT_SPARSE = 2,
    /* u_pi = [w_p >= i], k - 1 variables a site (Chancellor 2019); Potts and
       (truncated) linear. */
    QS_DOMAIN_WALL = 3,
    /* Heidari, Dinneen and Delmas 2022: one-hot with a terminal a label; Potts.
       nmk + k^2 variables. */
    QS_MULTIWAY_CUT = 4,
    /* The minimum cut of Ishikawa's graph, a variable a vertex (Heidari 2021),
     * and a variable an arc too (Cruz-Santos et al. 2019); linear without
     * truncation, which Potts is where there are two labels. nmk + nm + 2
     * variables, and 7nmk + 9nm - 2nk - 2mk - 2n - 2m + 2. */
    QS_ST_CUT = 5,
    QS_ST_CUT_ARCS = 6
} qs_encoding;

/* The penalty of what is no labelling: in the one-hot encodings a (1 - S) + b S
 * (S - 1) / 2 of each site, S = the number of its variables at 1; of a domain
 * wall kappa for each u_i = 0 before a u_i+1 = 1. W is the most that the site's
 * edges can cost: max_d sum_q max_l weight_pq V_pq(d, l); for Potts the sum of
 * their weights. docs/MATHS.md has the bounds and their proofs. */
typedef enum qs_penalty {
    /* The least proven for each site such that every infeasible state lies at
     * least `gap` above the minimum and, in the one-hot encodings, can be
     * improved by one flip. one-hot a = W + gap, b = a + gap; one-hot-sparse a
     * = gap, b = a + W + gap (linear costs: b = a + R w + gap with w the sum of
     * the weights and R = max_d sum_e max(0, T - |d - e|)); domain-wall kappa =
     * max_d theta(d) + W + gap (linear: docs/MATHS.md). */
    QS_PENALTY_LOCAL = 0,
    /* The paper's one alpha for all: the least integer above sum_p max_d
     * theta_p(d) + sum_pq weight_pq max V, of the costs as they are (not
     * shifted); a = alpha, b = 2 alpha. One-hot encodings and multiway-cut; not
     * one-hot-sparse of a linear cost, which needs more. */
    QS_PENALTY_PAPER = 1,
    QS_PENALTY_GIVEN =
        2, /* a = alpha, b = 2 alpha with the caller's alpha; nothing is proven
              of it. One-hot encodings and multiway-cut */
    /* The least proven for the gap alone: single flips may be caught in
     * infeasible states. Smaller than local in one-hot-sparse: b = a + W / 2 +
     * gap (linear costs: b = a + (6 T - 3) w / 4 + gap). */
    QS_PENALTY_MINIMAL = 3
} qs_penalty;

/* All zero = the defaults. */
typedef struct qs_encode_options {
    qs_encoding encoding;
    qs_penalty penalty;
    int64_t alpha; /* QS_PENALTY_GIVEN only: above 0, in integer units */
    uint32_t gap; /* QS_PENALTY_LOCAL and _MINIMAL only: integer units, up to
                     2^31 - 1; 0 = 1 */
} qs_encode_options;

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
