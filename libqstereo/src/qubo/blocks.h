/* The blocks of a .qcf, read where they stand (docs/FORMAT.md, BLKS). */
#ifndef QS_BLOCKS_H
#define QS_BLOCKS_H

#include <stdbool.h>
#include <stdint.h>

/* Bytes of the block at `p` of which `left` bytes are there; 0 = it is malformed or does not fit.
 */
uint64_t qs_block_size(const uint8_t *p, uint64_t left);

bool qs_block_is_table(const uint8_t *p);
uint32_t qs_block_rows(const uint8_t *p);
uint32_t qs_block_columns(const uint8_t *p);
int32_t qs_block_entry(const uint8_t *p, uint32_t row, uint32_t column);

/* Of the entries that are not 0. */
typedef struct qs_block_facts {
    uint64_t terms; /* how many */
    uint64_t absolute; /* sum of their absolute values, saturated at 2^63 */
    int64_t min, max; /* 0 where there is none */
} qs_block_facts;

qs_block_facts qs_block_summary(const uint8_t *p);

/* Of those above the diagonal alone: they count where a group is coupled with itself. */
qs_block_facts qs_block_upper(const uint8_t *p);

/* The sums of its rows and of its columns.
 *
 * rows, columns  out: as many as the block has */
void qs_block_sums(const uint8_t *p, int64_t *rows, int64_t *columns);

/* The sums for a group that the block couples with itself: for variable i that of row i and column
 * i above the diagonal.
 *
 * sums  out: as many as the block has rows */
void qs_block_own_sums(const uint8_t *p, int64_t *sums);

#endif
