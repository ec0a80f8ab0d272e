/* The QUBO that a .qcf holds, read where it stands in the file's bytes:
 *
 *     H(x) =   offset + sum_i linear_i x_i
 *            + sum over groups g of [ a_g (1 - S_g) + b_g S_g (S_g - 1) / 2 ]
 *            + sum over couplings (g, h, weight, block t) of
 *                  weight * sum_{i in g, j in h} t[i][j] x_i x_j
 *
 * with S_g the number of variables of the group g that are 1.
 *
 * The bits of a sample are packed as in a .qsf: x_i is bit i % 8 of byte
 * i / 8. */
#ifndef QSTEREO_QUBO_H
#define QSTEREO_QUBO_H

#include <stdbool.h>

#include "labels.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a file says is known of its optimum (docs/FORMAT.md, best). The bound is
 * a claim: nothing in the file proves it. */
typedef struct qs_known {
    unsigned bytes; /* of each label: 1 or 2; 0 = the file says nothing */
    const uint8_t *labels; /* of each group, in `bytes` */
    int64_t lower_bound; /* of H, in integer units; QS_NO_BOUND = none */
} qs_known;

/* A view: it borrows the file's bytes. Its fields are for reading. */
typedef struct qs_qubo {
    const uint8_t *bytes;
    size_t size;
    uint32_t variables, groups;
    uint64_t couplings;
    int64_t offset;
    bool has_labels; /* the file says what its variables mean, in `labels` */
    qs_labels labels;
    qs_known known;
    /* Payloads in the file, for the functions below. */
    const uint8_t *group_runs, *blocks, *coupling_runs, *linear, *penalty_runs;
    size_t group_run_count, penalty_run_count;
    uint32_t block_count, coupling_run_count;
    unsigned linear_bytes, penalty_bytes;
    int64_t linear_base;
} qs_qubo;

/* Opens a .qcf in memory and checks all that docs/FORMAT.md demands, but for
 * what needs an index (whether blocks fit the groups that they couple):
 * qs_index_build checks that.
 *
 * bytes         the whole file; the view borrows it
 * memory_limit  the most that qs_index_workspace of the view may be, in bytes.
 *               The counts in the header are checked against it before
 *               anything else is read
 * qubo          out
 * fault         out if the file is refused, may be NULL
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT     a null pointer
 *   QS_E_FORMAT       not a .qcf
 *   QS_E_TRUNCATED    cut short
 *   QS_E_CORRUPT      damaged
 *   QS_E_UNSUPPORTED  of a newer version
 *   QS_E_LIMIT        over the memory limit */
QS_MUST_CHECK qs_status qs_qubo_open(const void *bytes, size_t size,
                                     uint64_t memory_limit, qs_qubo *qubo,
                                     qs_fault *fault);

/* The QUBO as an annealer sees it: the penalties are a part of the linear and
 * quadratic terms. The least and the largest of each kind of coefficient, in
 * integer units. Quadratic terms are those that are not 0; where two groups are
 * coupled several times, each time counts. Without any, min = max = 0. */
typedef struct qs_qubo_summary {
    uint64_t quadratic_terms;
    int64_t offset; /* with the constants of the penalties */
    int64_t linear_min, linear_max;
    int64_t quadratic_min, quadratic_max;
    /* a: what a one-hot group without a variable at 1 costs. */
    int64_t penalty_min, penalty_max;
    /* b: what each pair of variables at 1 within a group costs. */
    int64_t pair_penalty_min, pair_penalty_max;
} qs_qubo_summary;

/* Reads the whole file once. */
void qs_qubo_summarise(const qs_qubo *qubo, qs_qubo_summary *summary);

/* linear_i, without the penalties' share. */
int64_t qs_qubo_linear(const qs_qubo *qubo, uint32_t variable);

/* The state of the labelling that the file carries: qubo->known has one.
 *
 * bits  out: all variables, packed, spare bits 0 */
void qs_qubo_known_state(const qs_qubo *qubo, uint8_t *bits);

/* ---- The index. ---- */

/* In qs_neighbour.block: the group's variables are the block's columns, not its
 * rows. */
#define QS_TRANSPOSED 0x80000000u

/* A neighbour of a group. */
typedef struct qs_neighbour {
    uint32_t group;
    uint32_t block; /* number of the block, with or without QS_TRANSPOSED */
    int32_t weight;
} qs_neighbour;

/* Where the variables, the penalty and the neighbours of each group are. The
 * energy and the repair of samples need it. */
typedef struct qs_index {
    const qs_qubo *qubo;
    const size_t *block_at; /* blocks: where each one begins in qubo->blocks */
    const uint32_t *start; /* groups + 1: first variable of each group */
    const uint32_t *near_start; /* groups + 1: each group's first neighbour */
    const qs_neighbour *near; /* each coupling twice, as either group sees it;
                                 of a group with itself once */
    const uint32_t *penalty_run; /* groups: number of the run that holds its
                                    penalty */
} qs_index;

/* Bytes of workspace for qs_index_build. Here and in all other such functions
 * SIZE_MAX = more than this machine can address. */
size_t qs_index_workspace(const qs_qubo *qubo);

/* Builds the index. It borrows the view and the workspace.
 *
 * workspace  qs_index_workspace bytes, aligned for any type
 * index      out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT   a null pointer
 *   QS_E_WORKSPACE  the workspace is too small
 *   QS_E_CORRUPT    a block does not fit the groups that it couples */
QS_MUST_CHECK qs_status qs_index_build(const qs_qubo *qubo, void *workspace,
                                       size_t workspace_size, qs_index *index);

/* The penalty (a, b) of a group. */
void qs_index_penalty(const qs_index *index, uint32_t group, int64_t *a,
                      int64_t *b);

/* t[row][column] of a block. */
int32_t qs_index_block(const qs_index *index, uint32_t block, uint32_t row,
                       uint32_t column);

/* H of a sample, in integer units. */
int64_t qs_qubo_energy(const qs_index *index, const uint8_t *bits);

/* ---- Ising. ---- */

/* The same QUBO as an Ising model of spins s_i = 2 x_i - 1, four times as large
 * so that there are no fractions:
 *
 *     4 H = constant + sum_i 4h_i s_i + sum_ij 4J_ij s_i s_j
 *     4h_i = 2 Q_ii + sum_j Q_ij,     4J_ij = Q_ij
 *
 * with Q the linear (Q_ii) and quadratic terms, the penalties among them. Here
 * are the least and the largest of the 4h_i, and of the 4J_ij that are not 0;
 * both are 0 where there is none. Where two groups are coupled several times,
 * 4J has each coupling by itself and 4h has their sum. */
typedef struct qs_ising {
    int64_t field_min, field_max; /* 4h */
    int64_t coupling_min, coupling_max; /* 4J */
} qs_ising;

/* Bytes of workspace for qs_qubo_ising: the sums of each block's rows and
 * columns. */
size_t qs_ising_workspace(const qs_qubo *qubo);

/* Computes the ranges, in a time of O(couplings x variables of a group).
 *
 * workspace  qs_ising_workspace bytes, aligned for any type
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT   a null pointer
 *   QS_E_WORKSPACE  the workspace is too small */
QS_MUST_CHECK qs_status qs_qubo_ising(const qs_index *index, void *workspace,
                                      size_t workspace_size, qs_ising *ising);

#ifdef __cplusplus
}
#endif

#endif
