#include "../../include/qstereo/qubo.h"
#include "blocks.h"
#include "../base/bytes.h"

/* Of a block as many sums as it has rows and columns, and as many again of a square one, for groups
 * that are coupled with themselves. */
static uint64_t sums_of(const uint8_t *block)
{
    uint64_t rows = qs_block_rows(block), columns = qs_block_columns(block);
    return rows + columns + (rows == columns ? rows : 0);
}

static uint64_t workspace_of(const qs_qubo *qubo)
{
    const uint8_t *at = qubo->blocks + 4;
    uint64_t sums = 0;
    for (uint32_t b = 0; b < qubo->block_count; b++) {
        sums += 1 + sums_of(at);
        at += qs_block_size(at, UINT64_MAX);
    }
    return sizeof(int64_t) * sums;
}

size_t qs_ising_workspace(const qs_qubo *qubo)
{
    return qs_size(workspace_of(qubo));
}

typedef struct sums {
    const qs_index *index;
    int64_t *start; /* of each block: where its sums begin in the workspace */
    int64_t *at;
} sums;

static sums sum_blocks(const qs_index *index, void *workspace)
{
    const qs_qubo *qubo = index->qubo;
    sums s = {index, workspace, workspace};
    int64_t next = qubo->block_count;
    for (uint32_t b = 0; b < qubo->block_count; b++) {
        const uint8_t *block = qubo->blocks + index->block_at[b];
        uint32_t rows = qs_block_rows(block), columns = qs_block_columns(block);
        s.start[b] = next;
        qs_block_sums(block, s.at + next, s.at + next + rows);
        if (rows == columns) {
            qs_block_own_sums(block, s.at + next + rows + columns);
        }
        next += (int64_t)sums_of(block);
    }
    return s;
}

/* The sums of a block for the variables of one of its groups. */
static const int64_t *near_sums(const sums *s, uint32_t group, const qs_neighbour *near)
{
    uint32_t b = near->block & ~QS_TRANSPOSED;
    const uint8_t *block = s->index->qubo->blocks + s->index->block_at[b];
    uint32_t rows = qs_block_rows(block), columns = qs_block_columns(block);
    bool turned = (near->block & QS_TRANSPOSED) != 0;
    return s->at + s->start[b] + (near->group == group ? rows + columns : turned ? rows : 0);
}

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
        ising->field_min = *first || field < ising->field_min ? field : ising->field_min;
        ising->field_max = *first || field > ising->field_max ? field : ising->field_max;
        *first = false;
    }
}

qs_status qs_qubo_ising(const qs_index *index, void *workspace, size_t workspace_size,
                        qs_ising *ising)
{
    if (!index || !ising || (!workspace && workspace_of(index->qubo) > 0)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < workspace_of(index->qubo)) {
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
