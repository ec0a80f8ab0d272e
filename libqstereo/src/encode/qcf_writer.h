/* The writer of .qcf files (docs/FORMAT.md, section 2). Who makes a QUBO says how large each chunk
 * is and puts what they hold; the writer knows their order, their heads and the header. */
#ifndef QS_QCF_WRITER_H
#define QS_QCF_WRITER_H

#include "../files/container.h"
#include "../files/qcf_layout.h"

/* A QUBO that is about to be written. Each function puts the runs or numbers of one chunk, without
 * the chunk's head; they are called in this order, each once, and not at all in a sizing pass. */
typedef struct qs_qcf {
    uint64_t variables, groups, couplings;
    uint64_t group_runs; /* their number */
    qs_payload *put_group_runs;
    uint32_t blocks; /* their number */
    uint64_t blocks_size; /* their bytes */
    qs_payload *put_blocks;
    uint32_t runs; /* of couplings: their number */
    uint64_t runs_size; /* their bytes */
    qs_payload *put_runs;
    int64_t linear_base;
    unsigned linear_bytes; /* of each linear term */
    qs_payload *put_linear;
    unsigned penalty_bytes; /* of each a and b */
    uint64_t penalty_runs; /* their number */
    qs_payload *put_penalty_runs;
    const int64_t *offset; /* looked at after the linear terms have been put */
    uint32_t side_chunks; /* their number */
    qs_payload *put_side_chunks; /* whole chunks; called in a sizing pass too */
    const void *context; /* of all these functions */
} qs_qcf;

/* Writes the file; size may be NULL. Returns QS_OK or QS_E_IO. */
QS_MUST_CHECK qs_status qs_qcf_write(const qs_qcf *qcf, const qs_sink *sink, uint64_t *size);

/* ---- Pieces of the chunks. ---- */

void qs_put_group_run(qs_writer *writer, qs_group_run run);

/* The head of a block. A table goes on with its entries row by row, a Toeplitz block with the
 * `count` diagonals from column - row = first on. */
void qs_put_table_head(qs_writer *writer, uint32_t rows, uint32_t columns);
void qs_put_toeplitz_head(qs_writer *writer, uint32_t rows, uint32_t columns, int64_t fill,
                          int64_t first, uint32_t count);

/* An entry of a block. */
void qs_put_entry(qs_writer *writer, int64_t entry);

/* The head of a run of couplings; its list of pairs follows, then its weights. */
void qs_put_run_head(qs_writer *writer, const qs_run *run);
void qs_put_pair(qs_writer *writer, uint32_t first, uint32_t second);

/* Bytes of each weight of a run. Weights are signed in the file.
 *
 * largest  over all weights: the weight, or -(weight + 1) where it is negative */
unsigned qs_weight_bytes(uint32_t largest);

void qs_put_penalty_run(qs_writer *writer, const qs_penalty_run *run, unsigned bytes);

#endif
