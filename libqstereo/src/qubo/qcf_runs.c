#include "qcf_runs.h"

#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../base/saturate.h"

/* ---- Groups. ---- */

qs_group_run qs_group_run_at(const qs_qubo *qubo, size_t run)
{
    const uint8_t *at = qubo->group_runs + run * QS_GROUP_RUN;
    return (qs_group_run){qs_load_u32(at), qs_load_u32(at + 4)};
}

/* ---- Couplings. ---- */

qs_run_view qs_run_at(const uint8_t *at)
{
    qs_run_view run = {.form = qs_load_u32(at + 4), .pairs = at + QS_RUN_HEAD};
    run.head = (qs_run){
        .block = qs_load_u32(at),
        .is_list = run.form == 1,
        .weight_bytes = qs_load_u32(at + 8),
        .weight = qs_load_i32(at + 12),
        .first = qs_load_u32(at + 16),
        .second = qs_load_u32(at + 20),
        .count = qs_load_u32(at + 24),
        .repeat = qs_load_u32(at + 28),
        .stride = qs_load_u32(at + 32),
    };
    run.weights = run.pairs + (run.head.is_list ? QS_PAIR * (uint64_t)run.head.count : 0);
    run.size = qs_run_size(&run.head);
    return run;
}

uint64_t qs_run_weight_sum(const qs_run_view *run)
{
    if (run->head.weight_bytes == 0) {
        return qs_absolute(run->head.weight) * qs_run_pairs(&run->head);
    }
    uint64_t sum = 0;
    for (uint32_t r = 0; r < run->head.repeat; r++) {
        for (uint32_t c = 0; c < run->head.count; c++) {
            sum += qs_absolute(qs_run_weight(run, r, c));
        }
    }
    return sum;
}

void qs_block_seek(const qs_qubo *qubo, qs_block_cursor *cursor, uint32_t block)
{
    if (cursor->at && cursor->block == block) {
        return;
    }
    if (!cursor->at) {
        cursor->at = qubo->blocks + QS_BLOCKS_HEAD;
    }
    for (; cursor->block < block; cursor->block++) {
        cursor->at += qs_block_size(cursor->at, UINT64_MAX);
    }
    cursor->whole = qs_block_summary(cursor->at);
    cursor->upper = qs_block_upper(cursor->at);
}

/* ---- Penalties. ---- */

qs_penalty_run qs_penalty_run_at(const qs_qubo *qubo, size_t run)
{
    unsigned bytes = qubo->penalty_bytes;
    const uint8_t *at = qubo->penalty_runs + run * qs_penalty_run_size(bytes);
    return (qs_penalty_run){
        .count = qs_load_u32(at),
        .a = qs_load_unsigned(at + 4, bytes),
        .b = qs_load_unsigned(at + 4 + bytes, bytes),
    };
}

bool qs_penalty_piece_next(const qs_qubo *qubo, qs_penalty_piece *piece)
{
    if (piece->run == qubo->penalty_run_count || piece->group_run == qubo->group_run_count) {
        return false;
    }
    qs_penalty_run run = qs_penalty_run_at(qubo, piece->run);
    qs_group_run groups = qs_group_run_at(qubo, piece->group_run);
    uint32_t left = run.count - piece->in_run, groups_left = groups.count - piece->in_group_run,
             count = qs_min_u32(left, groups_left);
    piece->count = count;
    piece->size = groups.size;
    piece->a = run.a;
    piece->b = run.b;
    piece->run += count == left;
    piece->in_run = count == left ? 0 : piece->in_run + count;
    piece->group_run += count == groups_left;
    piece->in_group_run = count == groups_left ? 0 : piece->in_group_run + count;
    return true;
}

/* ---- Linear terms. ---- */

int64_t qs_qubo_linear(const qs_qubo *qubo, uint32_t variable)
{
    size_t at = (size_t)variable * qubo->linear_bytes;
    return qubo->linear_base + (int64_t)qs_load_unsigned(qubo->linear + at, qubo->linear_bytes);
}
