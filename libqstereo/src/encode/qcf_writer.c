#include "qcf_writer.h"

#include "../base/bytes.h"

/* ---- Pieces of the chunks. ---- */

void qs_put_group_run(qs_writer *writer, qs_group_run run)
{
    qs_put_u32(writer, run.count);
    qs_put_u32(writer, run.size);
}

void qs_put_table_head(qs_writer *writer, uint32_t rows, uint32_t columns)
{
    qs_put_u32(writer, rows);
    qs_put_u32(writer, columns);
    qs_put_u32(writer, QS_BLOCK_IS_TABLE);
}

void qs_put_toeplitz_head(qs_writer *writer, uint32_t rows, uint32_t columns, int64_t fill,
                          int64_t first, uint32_t count)
{
    qs_put_u32(writer, rows);
    qs_put_u32(writer, columns);
    qs_put_u32(writer, QS_BLOCK_IS_TOEPLITZ);
    qs_put_u32(writer, (uint32_t)fill);
    qs_put_u32(writer, (uint32_t)first);
    qs_put_u32(writer, count);
}

void qs_put_entry(qs_writer *writer, int64_t entry)
{
    qs_put_u32(writer, (uint32_t)entry);
}

void qs_put_run_head(qs_writer *writer, const qs_run *run)
{
    const uint32_t fields[QS_RUN_HEAD / 4] = {
        run->block,  run->is_list, run->weight_bytes, (uint32_t)run->weight, run->first,
        run->second, run->count,   run->repeat,       run->stride,
    };
    for (int i = 0; i < QS_RUN_HEAD / 4; i++) {
        qs_put_u32(writer, fields[i]);
    }
}

void qs_put_pair(qs_writer *writer, uint32_t first, uint32_t second)
{
    qs_put_u32(writer, first);
    qs_put_u32(writer, second);
}

unsigned qs_weight_bytes(uint32_t largest)
{
    return qs_bytes_of(2 * (uint64_t)largest);
}

void qs_put_penalty_run(qs_writer *writer, const qs_penalty_run *run, unsigned bytes)
{
    qs_put_u32(writer, run->count);
    qs_put_unsigned(writer, run->a, bytes);
    qs_put_unsigned(writer, run->b, bytes);
}

/* ---- The chunks. ---- */

static void put_groups(qs_writer *writer, const void *context)
{
    const qs_qcf *q = context;
    q->put_group_runs(writer, q->context);
}

static void put_blocks(qs_writer *writer, const void *context)
{
    const qs_qcf *q = context;
    qs_put_u32(writer, q->blocks);
    q->put_blocks(writer, q->context);
}

static void put_couplings(qs_writer *writer, const void *context)
{
    const qs_qcf *q = context;
    qs_put_u32(writer, q->runs);
    q->put_runs(writer, q->context);
}

static void put_linear(qs_writer *writer, const void *context)
{
    const qs_qcf *q = context;
    qs_put_u64(writer, (uint64_t)q->linear_base);
    qs_put_u32(writer, q->linear_bytes);
    qs_put_u32(writer, 0);
    q->put_linear(writer, q->context);
}

static void put_penalties(qs_writer *writer, const void *context)
{
    const qs_qcf *q = context;
    qs_put_u32(writer, q->penalty_bytes);
    qs_put_u32(writer, 0);
    q->put_penalty_runs(writer, q->context);
}

static void put_offset(qs_writer *writer, const void *context)
{
    qs_put_u64(writer, (uint64_t)*((const qs_qcf *)context)->offset);
}

static void put_chunks(qs_writer *writer, const void *context)
{
    const qs_qcf *q = context;
    uint64_t penalties_size = q->penalty_runs * qs_penalty_run_size(q->penalty_bytes);
    qs_put_chunk(writer, "GRPS", q->group_runs * QS_GROUP_RUN, put_groups, q);
    qs_put_chunk(writer, "BLKS", QS_BLOCKS_HEAD + q->blocks_size, put_blocks, q);
    qs_put_chunk(writer, "CPLS", QS_RUNS_HEAD + q->runs_size, put_couplings, q);
    qs_put_chunk(writer, "LINR", QS_LINEAR_HEAD + q->variables * q->linear_bytes, put_linear, q);
    qs_put_chunk(writer, "PNLT", QS_PENALTIES_HEAD + penalties_size, put_penalties, q);
    qs_put_chunk(writer, "OFFS", 8, put_offset, q);
    q->put_side_chunks(writer, q->context);
}

qs_status qs_qcf_write(const qs_qcf *qcf, const qs_sink *sink, uint64_t *size)
{
    uint8_t fields[QS_HEADER_OWN] = {0};
    qs_store_u32(fields, (uint32_t)qcf->variables);
    qs_store_u32(fields + 4, (uint32_t)qcf->groups);
    qs_store_u64(fields + 8, qcf->couplings);
    return qs_write_file(sink, QS_MAGIC_QCF, QS_QCF_CHUNK_COUNT + qcf->side_chunks, fields,
                         put_chunks, qcf, size);
}
