#include "../../include/qstereo/qubo.h"

#include <string.h>

#include "../base/arena.h"
#include "qcf_runs.h"

/* The parts of the workspace. */
typedef struct parts {
    size_t *block_at;
    uint32_t *start, *near_start, *penalty_run;
    qs_neighbour *near;
} parts;

static parts take_parts(qs_arena *arena, const qs_qubo *q)
{
    uint64_t groups = q->groups;
    return (parts){
        .block_at = qs_arena_take(arena, q->block_count, sizeof(size_t)),
        .start = qs_arena_take(arena, groups + 1, sizeof(uint32_t)),
        .near_start = qs_arena_take(arena, groups + 1, sizeof(uint32_t)),
        .penalty_run = qs_arena_take(arena, groups, sizeof(uint32_t)),
        .near = qs_arena_take(arena, 2 * q->couplings, sizeof(qs_neighbour)),
    };
}

size_t qs_index_workspace(const qs_qubo *qubo)
{
    qs_arena arena = {0};
    take_parts(&arena, qubo);
    return qs_arena_size(&arena);
}

static void index_blocks(const qs_qubo *q, size_t *block_at)
{
    size_t at = QS_BLOCKS_HEAD;
    for (uint32_t b = 0; b < q->block_count; b++) {
        block_at[b] = at;
        at += (size_t)qs_block_size(q->blocks + at, UINT64_MAX);
    }
}

static void index_groups(const qs_qubo *q, uint32_t *start, uint32_t *penalty_run)
{
    uint32_t group = 0, variable = 0;
    for (size_t r = 0; r < q->group_run_count; r++) {
        qs_group_run run = qs_group_run_at(q, r);
        for (uint32_t i = 0; i < run.count; i++, variable += run.size) {
            start[group++] = variable;
        }
    }
    start[group] = variable;
    group = 0;
    for (size_t r = 0; r < q->penalty_run_count; r++) {
        uint32_t count = qs_penalty_run_at(q, r).count;
        for (uint32_t i = 0; i < count; i++) {
            penalty_run[group++] = (uint32_t)r;
        }
    }
}

/* Visits every pair of groups: once to count each group's neighbours, once to note them. */
static void index_pairs(const qs_qubo *q, uint32_t *near_start, qs_neighbour *near)
{
    const uint8_t *at = q->coupling_runs;
    for (uint32_t i = 0; i < q->coupling_run_count; i++) {
        qs_run_view run = qs_run_at(at);
        at += run.size;
        for (uint32_t r = 0; r < run.head.repeat; r++) {
            for (uint32_t c = 0; c < run.head.count; c++) {
                uint32_t g, h;
                qs_run_pair(&run, r, c, &g, &h);
                if (near) {
                    int32_t weight = qs_run_weight(&run, r, c);
                    near[near_start[g]] = (qs_neighbour){h, run.head.block, weight};
                    near[near_start[h]] =
                        g == h ? near[near_start[g]]
                               : (qs_neighbour){g, run.head.block | QS_TRANSPOSED, weight};
                }
                near_start[g]++;
                near_start[h] += g != h;
            }
        }
    }
}

/* The first pass counts the neighbours of each group. Sums of the counts say where each group's
 * neighbours begin. The second pass moves each beginning to the end, which is the beginning of the
 * next group: so all are shifted by one place. */
static void index_neighbours(const qs_qubo *q, uint32_t *near_start, qs_neighbour *near)
{
    memset(near_start, 0, (q->groups + 1u) * sizeof *near_start);
    index_pairs(q, near_start, NULL);
    uint32_t total = 0;
    for (uint32_t g = 0; g <= q->groups; g++) {
        uint32_t count = near_start[g];
        near_start[g] = total;
        total += count;
    }
    index_pairs(q, near_start, near);
    memmove(near_start + 1, near_start, q->groups * sizeof *near_start);
    near_start[0] = 0;
}

/* Returns true if a group and one of its neighbours have as many variables as the block has rows
 * and columns; a group that is coupled with itself must not have a penalty. */
static bool shape_agrees(const qs_index *index, uint32_t group, const qs_neighbour *near)
{
    const uint8_t *block = index->qubo->blocks + index->block_at[near->block & ~QS_TRANSPOSED];
    uint32_t own = index->start[group + 1] - index->start[group],
             other = index->start[near->group + 1] - index->start[near->group];
    bool turned = (near->block & QS_TRANSPOSED) != 0;
    int64_t a = 0, b = 0;
    if (near->group == group) {
        qs_index_penalty(index, group, &a, &b);
    }
    return qs_block_rows(block) == (turned ? other : own) &&
           qs_block_columns(block) == (turned ? own : other) && a == 0 && b == 0;
}

static bool shapes_agree(const qs_index *index)
{
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            if (!shape_agrees(index, g, &index->near[n])) {
                return false;
            }
        }
    }
    return true;
}

qs_status qs_index_build(const qs_qubo *qubo, void *workspace, size_t workspace_size,
                         qs_index *index)
{
    if (!qubo || !workspace || !index) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_index_workspace(qubo)) {
        return QS_E_WORKSPACE;
    }
    qs_arena arena = {.base = workspace};
    parts p = take_parts(&arena, qubo);
    index_blocks(qubo, p.block_at);
    index_groups(qubo, p.start, p.penalty_run);
    index_neighbours(qubo, p.near_start, p.near);
    qs_index built = {qubo, p.block_at, p.start, p.near_start, p.near, p.penalty_run};
    if (!shapes_agree(&built)) {
        return QS_E_CORRUPT;
    }
    *index = built;
    return QS_OK;
}

void qs_index_penalty(const qs_index *index, uint32_t group, int64_t *a, int64_t *b)
{
    qs_penalty_run run = qs_penalty_run_at(index->qubo, index->penalty_run[group]);
    *a = (int64_t)run.a;
    *b = (int64_t)run.b;
}

int32_t qs_index_block(const qs_index *index, uint32_t block, uint32_t row, uint32_t column)
{
    return qs_block_entry(index->qubo->blocks + index->block_at[block], row, column);
}
