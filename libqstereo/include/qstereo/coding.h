/* How a labelling is written as bits: the encodings, their penalties, and one
 * table that says what each encoding holds and how large it is. docs/MATHS.md
 * derives them, docs/FORMAT.md (side chunk labl) lists their variables. */
#ifndef QSTEREO_CODING_H
#define QSTEREO_CODING_H

#include <stdbool.h>

#include "problem.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The published ways to write a labelling as bits. The values are those of the
 * file. k is the number of labels, T the truncation, weight that of an edge. */
typedef enum qs_encoding {
    /* What qs_encoding_default chooses. It never stands in a file. */
    QS_ENCODING_DEFAULT = 0,
    /* A variable x_pd for each site p and label d; exactly one of each site's
     * variables is 1. An edge is
     *     weight * sum_{d,e} V(d, e) x_pd x_qe,
     * for Potts k (k - 1) terms. Holds every V.
     * (Heidari, Dinneen and Delmas, eq. (5).) */
    QS_ONE_HOT = 1,
    /* The same variables with fewer terms. An edge of Potts is
     *     weight * (1 - sum_d x_pd x_qd),
     * k terms that cost the same on every labelling; of linear costs
     *     weight * (T - sum_{|d-e|<T} (T - |d - e|) x_pd x_qe). */
    QS_ONE_HOT_SPARSE = 2,
    /* u_pi = 1 where the label of site p is at least i: k - 1 variables a site
     * (Chancellor 2019). Holds every V; where it is neither Potts nor linear,
     * the penalty grows with the number of labels left to the sites. */
    QS_DOMAIN_WALL = 3,
    /* One-hot, and a terminal with k variables for each label: sites * k + k^2
     * variables. Potts. (Heidari, Dinneen and Delmas 2022.) */
    QS_MULTIWAY_CUT = 4,
    /* The minimum cut of Ishikawa's graph, a variable a vertex: sites * (k + 1)
     * + 2 variables (Heidari 2021). Linear without truncation; Potts of two
     * labels is the same. */
    QS_ST_CUT = 5,
    /* The same cut with a variable for each arc too (Cruz-Santos et al.
     * 2019). */
    QS_ST_CUT_ARCS = 6
} qs_encoding;

#define QS_ENCODINGS 6 /* encodings 1 .. QS_ENCODINGS */

/* The penalty of a state that is not a labelling. With S the number of a site's
 * variables that are 1, the one-hot encodings add
 *     a (1 - S) + b S (S - 1) / 2
 * for each site. A domain wall adds kappa for each u_i = 0 before a u_i+1 = 1.
 * Below, w is the sum of the weights of a site's edges, and W is the most that
 * these edges can cost:
 *     W = max_d sum_q weight_pq max_e V(d, e);
 * for Potts W = w. docs/MATHS.md proves the bounds. */
typedef enum qs_penalty {
    /* The least that is proven, site by site: every infeasible state lies at
     * least `gap` above the minimum, and in the one-hot encodings one flip
     * improves it.
     *     one-hot         a = W + gap, b = a + gap
     *     one-hot-sparse  a = gap, b = a + W + gap; of linear costs
     *                     b = a + R w + gap, R = max_d sum_e max(0, T - |d-e|)
     *     domain-wall     kappa = max_d theta(d) + W + gap (of other costs
     *                     see docs/MATHS.md) */
    QS_PENALTY_LOCAL = 0,
    /* The paper's alpha, one for all sites: a = alpha, b = 2 alpha, with alpha
     * the least integer above
     *     sum_p max_d theta_p(d) + sum_pq weight_pq max V,
     * of the costs as they are given (not shifted). */
    QS_PENALTY_PAPER = 1,
    /* a = alpha, b = 2 alpha with the caller's alpha. Nothing is proven. */
    QS_PENALTY_GIVEN = 2,
    /* The least that is proven for the gap alone: an infeasible state may have
     * no flip that improves it. Smaller than local in one-hot-sparse:
     *     b = a + W / 2 + gap; of linear costs b = a + (6 T - 3) w / 4 + gap */
    QS_PENALTY_MINIMAL = 3
} qs_penalty;

/* How a QUBO is to be written. All zero = the defaults. */
typedef struct qs_encode_options {
    qs_encoding encoding;
    qs_penalty penalty;
    int64_t alpha; /* QS_PENALTY_GIVEN only: above 0, in integer units */
    uint32_t gap; /* QS_PENALTY_LOCAL and _MINIMAL only: in integer units, at
                     most 2^31 - 1; 0 = 1 */
} qs_encode_options;

/* What the variables of one site say. A site has n labels (numbered 0 .. n - 1
 * in rising order); j is the number of the one that it takes. */
typedef enum qs_site_code {
    QS_CODE_ONE_HOT, /* n variables: the j-th is 1, the others are 0 */
    QS_CODE_WALL, /* n - 1 variables: j times 1, then 0 */
    QS_CODE_CHAIN /* n + 1 variables: j + 1 times 1, then 0, at least one 0 */
} qs_site_code;

/* The variables that follow those of the sites. A QUBO without undecided sites
 * has none of them. */
typedef enum qs_auxiliaries {
    QS_NO_AUXILIARIES,
    QS_TERMINALS, /* for each label k variables: the one of that label is 1 */
    QS_SOURCE_AND_SINK, /* two variables: 1, then 0 */
    QS_SOURCE_SINK_AND_ARCS /* then one for each arc: 1 where it is cut */
} qs_auxiliaries;

/* How qs_sample_repair makes a sample feasible (sample.h). */
typedef enum qs_repair {
    QS_REPAIR_BY_FLIPS,
    QS_REPAIR_BY_LABEL_ORDER,
    QS_REPAIR_SITE_BY_SITE,
    QS_REPAIR_BY_THRESHOLDS,
    QS_REPAIR_BY_CHOICE
} qs_repair;

/* A row of the table of encodings. */
typedef struct qs_encoding_facts {
    qs_encoding encoding;
    const char *name; /* "one-hot-sparse": of the command and of JSON */
    const char *holds; /* the smoothness it can hold: "potts and linear" */
    const char *feasible; /* when a sample is a labelling, as a main clause */
    /* Penalties that it has, the bit 1 << qs_penalty each. */
    unsigned penalties_of_potts, penalties_of_others;
    qs_site_code code;
    qs_auxiliaries auxiliaries;
    bool is_streamed; /* qs_encode writes it from the costs; its whole problems
                         need no chunk kept */
    bool has_model; /* qs_model_build reads it */
} qs_encoding_facts;

/* The facts of an encoding. NULL: it is none of 1 .. QS_ENCODINGS. */
const qs_encoding_facts *qs_encoding_facts_of(qs_encoding encoding);

/* The encoding that QS_ENCODING_DEFAULT stands for: one-hot-sparse for Potts,
 * else one-hot. */
qs_encoding qs_encoding_default(const qs_pairwise *pairwise);

/* Returns true if an encoding can hold a pairwise cost of `labels` labels. */
bool qs_encoding_holds(qs_encoding encoding, const qs_pairwise *pairwise,
                       uint32_t labels);

/* Returns true if an encoding has a penalty for some pairwise cost. */
bool qs_encoding_has_penalty(qs_encoding encoding, qs_penalty penalty);

/* Returns true if an encoding has a penalty for this pairwise cost. The paper's
 * alpha is too small for one-hot-sparse of linear costs (docs/MATHS.md). */
bool qs_encoding_allows_penalty(qs_encoding encoding, qs_penalty penalty,
                                const qs_pairwise *pairwise);

/* Returns true for the penalties that are proven site by site and keep a gap:
 * local and minimal. */
bool qs_penalty_keeps_gap(qs_penalty penalty);

/* Variables of an undecided site with `labels` labels left. */
uint32_t qs_encoding_site_variables(qs_encoding encoding, uint32_t labels);

/* What decides how large a QUBO is. A site is undecided where it has variables:
 * where two labels or more are left to it. */
typedef struct qs_encoding_counts {
    uint32_t labels; /* of the problem: k */
    uint64_t undecided; /* sites */
    uint64_t labels_left; /* summed over the undecided sites */
    uint64_t edges; /* between undecided sites */
    /* Of the cuts only. The labels left to either of an edge's two sites part
     * the boundaries 0 .. k (below, between and above labels) into ranges that
     * are the same to both; this is the sum of their numbers over the edges:
     * k + 1 for each edge where no label has left. */
    uint64_t thresholds;
} qs_encoding_counts;

/* How large a QUBO is. */
typedef struct qs_encoding_size {
    uint64_t variables;
    uint64_t groups;
    uint64_t couplings; /* pairs of groups, at most. In the cuts groups have one
                           variable: if each edge counted has a weight above 0,
                           this is the number of quadratic terms */
} qs_encoding_size;

/* The size of a QUBO in an encoding, which need not hold its pairwise cost. */
qs_encoding_size qs_encoding_measure(qs_encoding encoding,
                                     const qs_encoding_counts *counts);

/* How samples of an encoding are repaired. */
qs_repair qs_encoding_repair(qs_encoding encoding, qs_penalty penalty,
                             const qs_pairwise *pairwise, uint32_t labels);

/* Fills in what options leave to the defaults, and checks them.
 *
 * settled  out: the encoding is never QS_ENCODING_DEFAULT, the gap at least 1
 *          (1 where the penalty keeps none)
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a value outside its range
 *   QS_E_OVERFLOW  alpha is above 2^53
 *   QS_E_ENCODING  the encoding cannot hold the pairwise cost, or does not have
 *                  this penalty for it */
QS_MUST_CHECK qs_status qs_encode_settle(const qs_encode_options *options,
                                         const qs_pairwise *pairwise,
                                         uint32_t labels,
                                         qs_encode_options *settled);

#ifdef __cplusplus
}
#endif

#endif
