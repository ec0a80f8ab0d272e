/* Sizes of the parts of a .qcf in bytes, and the head of a run of couplings: what its writer and
 * its reader must agree on (docs/FORMAT.md, section 2). */
#ifndef QS_QCF_LAYOUT_H
#define QS_QCF_LAYOUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The chunks of every .qcf, in their order. */
#define QS_QCF_CHUNKS "GRPSBLKSCPLSLINRPNLTOFFS"

enum {
    QS_QCF_CHUNK_COUNT = 6,
    QS_GROUP_RUN = 8, /* GRPS: of each run */
    QS_BLOCKS_HEAD = 4, /* BLKS */
    QS_TABLE_HEAD = 12, /* of a block that is a table */
    QS_TOEPLITZ_HEAD = 24, /* of a Toeplitz block */
    QS_RUNS_HEAD = 4, /* CPLS */
    QS_RUN_HEAD = 36, /* of each run of couplings */
    QS_PAIR = 8, /* of each pair of groups in a list */
    QS_LINEAR_HEAD = 16, /* LINR */
    QS_PENALTIES_HEAD = 8, /* PNLT */
    QS_LABL_HEAD = 64, /* labl without its mask */
    QS_MEAN_SIZE = 24,
    QS_KEPT_HEAD = 8,
    QS_TRNC_HEAD = 8,
    QS_KNOWN_HEAD = 16 /* best */
};

/* The kind of a block, the third number of its head. */
enum { QS_BLOCK_IS_TABLE = 0, QS_BLOCK_IS_TOEPLITZ = 1 };

/* A run of groups with `size` variables each. */
typedef struct qs_group_run {
    uint32_t count, size;
} qs_group_run;

/* A run of groups with the penalty (a, b). */
typedef struct qs_penalty_run {
    uint64_t a, b;
    uint32_t count;
} qs_penalty_run;

/* Bytes of a run of penalties, whose a and b have `bytes` bytes each. */
static inline size_t qs_penalty_run_size(unsigned bytes)
{
    return 4 + 2 * (size_t)bytes;
}

/* Bits of a mask or of a label set, rounded up to bytes. */
static inline uint64_t qs_bit_bytes(uint64_t bits)
{
    return (bits + 7) / 8;
}

/* A run of couplings: count x repeat pairs of groups that share a block. */
typedef struct qs_run {
    uint32_t block;
    bool is_list; /* its pairs are listed; else they are computed from the fields below */
    unsigned weight_bytes; /* of each weight; 0 = all weights are `weight` */
    int32_t weight;
    uint32_t first, second; /* the first pair */
    uint32_t count; /* pairs one after another, in which both groups rise by 1 */
    uint32_t repeat,
        stride; /* so many times, both groups rising by `stride` from one to the next */
} qs_run;

static inline uint64_t qs_run_pairs(const qs_run *run)
{
    return (uint64_t)run->count * run->repeat;
}

/* Bytes of the run in the file. */
static inline uint64_t qs_run_size(const qs_run *run)
{
    uint64_t listed = run->is_list ? QS_PAIR * (uint64_t)run->count : 0;
    return QS_RUN_HEAD + listed + qs_run_pairs(run) * run->weight_bytes;
}

#endif
