/* The QUBO that a .qcf holds, seen in its bytes:
 *
 *     H(x) = offset + sum_i linear_i x_i + sum_g [ a_g (1 - S_g) + b_g S_g (S_g
 * - 1) / 2 ]
 *          + sum over couplings (g, h, weight, block t): weight * sum_{i in g,
 * j in h} t[i][j] x_i x_j
 *
 * Sample bits are packed as in a .qsf: x_i is bit i % 8 of byte i / 8. */
#ifndef QSTEREO_QUBO_H
#define QSTEREO_QUBO_H

#include <stdbool.h>

#include "labels.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A view: it borrows the file's bytes. Its fields are for reading. */
typedef struct qs_qubo {
    const uint8_t *bytes;
    size_t size;
    uint32_t variables, groups;
    uint64_t couplings;
    int64_t offset;
    bool has_labels; /* the side chunk labl is there, and: */
    qs_labels labels;
    /* Payloads in the file, for the functions below. */
    const uint8_t *group_runs, *blocks, *coupling_runs, *linear, *penalty_runs;
    size_t group_run_count, penalty_run_count;
    uint32_t block_count, coupling_run_count;
    unsigned linear_bytes, penalty_bytes;
    int64_t linear_base;
} qs_qubo;

/* Opens a .qcf in memory and checks everything that docs/FORMAT.md demands, but
 * for what needs an index (the sizes of the groups that meet in a coupling):
 * qs_index_build checks that.
 *
 * bytes         the whole file; borrowed by the view
 * memory_limit  the most that qs_index_workspace of the view may be; it is
 * checked from the header's counts before the rest is looked at fault out on
 * failure, may be NULL Returns QS_OK, QS_E_ARGUMENT, QS_E_FORMAT,
 * QS_E_TRUNCATED, QS_E_CORRUPT, QS_E_UNSUPPORTED, QS_E_LIMIT. */
QS_MUST_CHECK qs_status qs_qubo_open(const void *bytes, size_t size,
                                     uint64_t memory_limit, qs_qubo *qubo,
                                     qs_fault *fault);

/* The QUBO as an annealer sees it, penalties folded in: of each kind of
 * coefficient the least and the largest, in integer units. Quadratic terms are
 * those that are not 0 (repeated pairs of groups are counted each time);
 * without any, min = max = 0. */
typedef struct qs_qubo_summary {
    uint64_t quadratic_terms;
    int64_t offset; /* with the penalties' constants */
    int64_t linear_min, linear_max;
    int64_t quadratic_min, quadratic_max;
    int64_t penalty_min, penalty_max; /* a: what an empty one-hot group costs */
    int64_t pair_penalty_min,
        pair_penalty_max; /* b: what each pair at 1 within a group costs */
} qs_qubo_summary;

void qs_qubo_summarise(const qs_qubo *qubo, qs_qubo_summary *summary);

#define QS_TRANSPOSED 0x80000000u

/* A neighbour of a group. */
typedef struct qs_neighbour {
    uint32_t group;
    uint32_t block; /* with QS_TRANSPOSED: this group's variables are the
                       block's columns, not its rows */
    int32_t weight;
} qs_neighbour;

/* Where each group's variables, penalties and neighbours are: what the energies
 * and the repair of samples need. */
typedef struct qs_index {
    const qs_qubo *qubo;
    const size_t *block_at; /* blocks: offset of each in qubo->blocks */
    const uint32_t *start; /* groups + 1: first variable of each group */
    const uint32_t
        *near_start; /* groups + 1: first of each group's neighbours */
    const qs_neighbour
        *near; /* each coupling twice; of a group with itself once */
    const uint32_t *penalty_run; /* groups: index of the run that holds the
                                    group's penalty */
} qs_index;

/* Bytes of workspace for qs_index_build; here and in all other such functions
 * SIZE_MAX = more than this machine can address. */
size_t qs_index_workspace(const qs_qubo *qubo);

/* Builds the index. It borrows the view and the workspace (aligned for any
 * type). Returns QS_OK, QS_E_ARGUMENT, QS_E_WORKSPACE, or QS_E_CORRUPT (a block
 * does not fit the groups that it couples). */
QS_MUST_CHECK qs_status qs_index_build(const qs_qubo *qubo, void *workspace,
                                       size_t workspace_size, qs_index *index);

/* linear_i, without the penalties' share. */
int64_t qs_qubo_linear(const qs_qubo *qubo, uint32_t variable);

/* The penalty pair (a, b) of a group. */
void qs_index_penalty(const qs_index *index, uint32_t group, int64_t *a,
                      int64_t *b);

/* t[row][column] of a block. */
int32_t qs_index_block(const qs_index *index, uint32_t block, uint32_t row,
                       uint32_t column);

/* The same QUBO as an Ising model of spins s_i = 2 x_i - 1, four times as
 * large, so that there are no fractions: 4 H = constant + sum_i 4h_i s_i +
 * sum_ij 4J_ij s_i s_j with 4h_i = 2 Q_ii + sum_j Q_ij and 4J_ij = Q_ij,
 * penalties folded in. Of the 4h_i, and of the 4J_ij that are not 0, the least
 * and the largest; where there is none both are 0. The couplings of a pair of
 * groups that is repeated are each seen by themselves in 4J, added up in 4h. */
typedef struct qs_ising {
    int64_t field_min, field_max; /* 4h */
    int64_t coupling_min, coupling_max; /* 4J */
} qs_ising;

/* Bytes of workspace for qs_qubo_ising: the sums of each block's rows and
 * columns. */
size_t qs_ising_workspace(const qs_qubo *qubo);

/* Computes the ranges in O(couplings x variables of a group), from the sums of
 * each block's rows and columns. Returns QS_OK, QS_E_ARGUMENT or
 * QS_E_WORKSPACE. */
QS_MUST_CHECK qs_status qs_qubo_ising(const qs_index *index, void *workspace,
                                      size_t workspace_size, qs_ising *ising);

/* H of a sample, in integer units. */
int64_t qs_qubo_energy(const qs_index *index, const uint8_t *bits);

#ifdef __cplusplus
}
#endif

#endif
