#include "../../include/qstereo/qubo.h"

#include "../base/arena.h"
#include "../base/bytes.h"
#include "../base/minmax.h"
#include "../files/qcf_layout.h"
#include "blocks.h"

/* Of each block the sums of its rows and of its columns; of a square one also those for a group
 * that is coupled with itself. */
typedef struct sums {
    const qs_index *index;
    uint64_t *start; /* of each block: where its sums begin */
    int64_t *at;
} sums;

static uint64_t sums_of(const uint8_t *block)
{
    uint64_t rows = qs_block_rows(block), columns = qs_block_columns(block);
    return rows + columns + (rows == columns ? rows : 0);
}

static sums take_sums(qs_arena *arena, const qs_qubo *qubo)
{
    const uint8_t *at = qubo->blocks + QS_BLOCKS_HEAD;
    uint64_t count = 0;
    for (uint32_t b = 0; b < qubo->block_count; b++) {
        count += sums_of(at);
        at += qs_block_size(at, UINT64_MAX);
    }
    return (sums){
        .start = qs_arena_take(arena, qubo->block_count, sizeof(uint64_t)),
        .at = qs_arena_take(arena, count, sizeof(int64_t)),
    };
}

size_t qs_ising_workspace(const qs_qubo *qubo)
{
    qs_arena arena = {0};
    take_sums(&arena, qubo);
    return qs_arena_size(&arena);
}

static const uint8_t *block_of(const sums *s, uint32_t block)
{
    return s->index->qubo->blocks + s->index->block_at[block];
}

static sums sum_blocks(const qs_index *index, void *workspace)
{
    qs_arena arena = {.base = workspace};
    sums s = take_sums(&arena, index->qubo);
    s.index = index;
    uint64_t next = 0;
    for (uint32_t b = 0; b < index->qubo->block_count; b++) {
        const uint8_t *block = block_of(&s, b);
        uint32_t rows = qs_block_rows(block), columns = qs_block_columns(block);
        s.start[b] = next;
        qs_block_sums(block, s.at + next, s.at + next + rows);
        if (rows == columns) {
            qs_block_own_sums(block, s.at + next + rows + columns);
        }
        next += sums_of(block);
    }
    return s;
}

/* The sums of a block for the variables of one of its groups. */
static const int64_t *near_sums(const sums *s, uint32_t group, const qs_neighbour *near)
{
    uint32_t number = near->block & ~QS_TRANSPOSED;
    const uint8_t *block = block_of(s, number);
    const int64_t *rows = s->at + s->start[number], *columns = rows + qs_block_rows(block);
    if (near->group == group) {
        return columns + qs_block_columns(block);
    }
    return (near->block & QS_TRANSPOSED) != 0 ? columns : rows;
}

/* Widens the range of 4h by the variables of a group. */
static void add_group(const sums *s, uint32_t group, bool *first, qs_ising *ising)
{
    const qs_index *index = s->index;
    uint32_t from = index->start[group], size = index->start[group + 1] - from;
    int64_t a, b;
    qs_index_penalty(index, group, &a, &b);
    for (uint32_t i = 0; i < size; i++) {
        int64_t field = 2 * (qs_qubo_linear(index->qubo, from + i) - a) + b * (size - 1);
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            field += near_sums(s, group, &index->near[n])[i] * index->near[n].weight;
        }
        ising->field_min = *first ? field : qs_min_i64(ising->field_min, field);
        ising->field_max = *first ? field : qs_max_i64(ising->field_max, field);
        *first = false;
    }
}

qs_status qs_qubo_ising(const qs_index *index, void *workspace, size_t workspace_size,
                        qs_ising *ising)
{
    if (!index || !ising || (!workspace && qs_ising_workspace(index->qubo) > 0)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_ising_workspace(index->qubo)) {
        return QS_E_WORKSPACE;
    }
    qs_qubo_summary summary;
    qs_qubo_summarise(index->qubo, &summary);
    sums s = sum_blocks(index, workspace);
    *ising =
        (qs_ising){.coupling_min = summary.quadratic_min, .coupling_max = summary.quadratic_max};
    bool first = true;
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        add_group(&s, g, &first, ising);
    }
    return QS_OK;
}
