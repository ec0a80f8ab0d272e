/* The runs of a .qcf, read where they stand: groups, couplings and penalties (docs/FORMAT.md). */
#ifndef QS_QCF_RUNS_H
#define QS_QCF_RUNS_H

#include "../../include/qstereo/qubo.h"
#include "../base/bytes.h"
#include "../files/qcf_layout.h"
#include "blocks.h"

/* ---- Groups. ---- */

qs_group_run qs_group_run_at(const qs_qubo *qubo, size_t run);

/* ---- Couplings. ---- */

/* A run, and where the rest of it stands. */
typedef struct qs_run_view {
    qs_run head;
    uint32_t form; /* as in the file: 1 = a list, 0 = a lattice */
    const uint8_t *pairs; /* of a list */
    const uint8_t *weights; /* where they differ */
    uint64_t size; /* in the file */
} qs_run_view;

/* The run at `at`, of which at least the head is there. Nothing is checked. */
qs_run_view qs_run_at(const uint8_t *at);

/* Pair c of repetition r. */
static inline void qs_run_pair(const qs_run_view *run, uint32_t r, uint32_t c, uint32_t *first,
                               uint32_t *second)
{
    if (run->head.is_list) {
        *first = qs_load_u32(run->pairs + QS_PAIR * (size_t)c);
        *second = qs_load_u32(run->pairs + QS_PAIR * (size_t)c + 4);
    } else {
        *first = run->head.first + r * run->head.stride + c;
        *second = run->head.second + r * run->head.stride + c;
    }
}

/* Its weight. */
static inline int32_t qs_run_weight(const qs_run_view *run, uint32_t r, uint32_t c)
{
    unsigned bytes = run->head.weight_bytes;
    uint64_t at = ((uint64_t)r * run->head.count + c) * bytes;
    return bytes == 0 ? run->head.weight : qs_load_signed(run->weights + at, bytes);
}

/* The sum of the absolute weights. */
uint64_t qs_run_weight_sum(const qs_run_view *run);

/* The block of a run. The blocks of runs never fall, so one pass over all blocks finds them. Zero =
 * before the first. */
typedef struct qs_block_cursor {
    const uint8_t *at;
    uint32_t block;
    qs_block_facts whole, upper;
} qs_block_cursor;

void qs_block_seek(const qs_qubo *qubo, qs_block_cursor *cursor, uint32_t block);

/* ---- Penalties. ---- */

qs_penalty_run qs_penalty_run_at(const qs_qubo *qubo, size_t run);

/* Walks the runs of penalties and of groups side by side, in pieces of one size and one pair (a, b)
 * each. Zero = before the first. */
typedef struct qs_penalty_piece {
    size_t run, group_run;
    uint32_t in_run, in_group_run; /* groups of each that are behind the cursor */
    /* This piece: */
    uint64_t count, size;
    uint64_t a, b;
} qs_penalty_piece;

/* The next piece; false after the last. */
bool qs_penalty_piece_next(const qs_qubo *qubo, qs_penalty_piece *piece);

#endif
