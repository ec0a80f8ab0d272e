/* A QUBO under construction, in the caller's memory. */
#ifndef QS_DRAFT_H
#define QS_DRAFT_H

#include <stdbool.h>

#include "../base/arena.h"
#include "../base/saturate.h"
#include "../encode/qcf_writer.h"

/* Room that a draft needs: at most so many of each. */
typedef struct qs_draft_sizes {
    uint64_t variables;
    uint64_t runs; /* of groups, and of penalties */
    uint64_t pairs;
} qs_draft_sizes;

/* Two coupled groups, first <= second. */
typedef struct qs_draft_pair {
    uint32_t first, second;
    uint32_t block; /* with QS_NEW_RUN: this pair begins a run of its own */
    int32_t weight;
} qs_draft_pair;

#define QS_NEW_RUN 0x80000000u

typedef struct qs_block_shape {
    uint32_t rows, columns;
    bool toeplitz;
    int64_t fill; /* of a Toeplitz block: what most entries are */
} qs_block_shape;

/* The blocks are not stored: their shapes and entries are computed when they are needed. */
typedef qs_block_shape qs_shape_of(const void *context, uint32_t block);
typedef int64_t qs_entry_of(const void *context, uint32_t block, uint32_t row, uint32_t column);

typedef struct qs_draft {
    uint64_t variables, groups;
    int64_t offset;
    int64_t *linear; /* all 0 at first */
    qs_group_run *group_runs;
    qs_penalty_run *penalty_runs;
    qs_draft_pair *pairs; /* their blocks do not fall */
    size_t group_run_count, penalty_run_count, pair_count;
    bool overflow; /* a coefficient does not fit */
    /* Set by who fills it: */
    uint32_t lattice; /* pairs that are worth a lattice; fewer are listed */
    uint32_t block_count;
    qs_shape_of *shape;
    qs_entry_of *entry;
    const void *blocks; /* context of both */
} qs_draft;

/* Takes a draft's memory. In a counting pass the returned draft must not be used. */
qs_draft qs_draft_take(qs_arena *arena, qs_draft_sizes sizes);

/* Appends `count` groups of `size` variables each, with the penalty (a, b). */
void qs_draft_groups(qs_draft *draft, uint32_t count, uint32_t size, uint64_t a, uint64_t b);

/* Adds to the offset or a linear term. |value| is at most 2^62. */
static inline void qs_draft_add(qs_draft *draft, int64_t *sum, int64_t value)
{
    qs_add(sum, value, &draft->overflow);
}

/* Appends a pair of groups. */
void qs_draft_couple(qs_draft *draft, uint32_t first, uint32_t second, uint32_t block,
                     int64_t weight);

/* The sum of the absolute entries of a block, saturated above QS_ENERGY_MAX. */
uint64_t qs_draft_block_sum(const qs_draft *draft, uint32_t block);

/* Writes the file.
 *
 * side_count  how many chunks put_side puts, being given `context`
 * Returns QS_OK, QS_E_OVERFLOW or QS_E_LIMIT (before anything is written), QS_E_IO. */
QS_MUST_CHECK qs_status qs_draft_write(const qs_draft *draft, uint32_t side_count,
                                       qs_payload *put_side, const void *context,
                                       const qs_sink *sink, uint64_t *size);

#endif
