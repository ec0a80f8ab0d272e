#include "../../include/qstereo/encode.h"

#include "../base/saturate.h"
#include "../problem/cost_strips.h"
#include "encoder.h"
#include "labl_chunk.h"

/* ---- Workspace. ---- */

static void take_workspace(qs_arena *arena, const qs_problem *problem, qs_encoder *e)
{
    bool grid = problem->grid.width > 0, table = problem->pairwise.smoothness == QS_TABLE;
    uint64_t sums = grid ? 0 : 2 * (uint64_t)problem->sites,
             largest = table ? 2 * (uint64_t)problem->labels : 0;
    e->sums = qs_arena_take(arena, sums, sizeof *e->sums);
    e->largest = qs_arena_take(arena, largest, sizeof *e->largest);
    e->costs = qs_arena_take(arena, qs_costs_workspace(problem), 1);
#ifndef QS_SMALL
    if (qs_has_tables(e)) {
        uint64_t entries = (uint64_t)problem->labels * problem->labels;
        e->strip = qs_table_strip_first(e->problem, arena);
        e->last_table = qs_arena_take(arena, entries, sizeof *e->last_table);
        e->reach = qs_arena_take(arena, qs_table_reach_numbers(problem), sizeof *e->reach);
    }
#endif
}

size_t qs_encode_workspace(const qs_problem *problem)
{
    qs_arena arena = {0};
    qs_encoder e = {.problem = problem};
    take_workspace(&arena, problem, &e);
    return qs_arena_size(&arena);
}

/* ---- The file. ---- */

static void put_groups(qs_writer *writer, const void *context)
{
    const qs_encoder *e = context;
    qs_put_group_run(writer, (qs_group_run){(uint32_t)e->qcf.groups, e->problem->labels});
}

/* In place: a copy would double what this takes of the stack. */
static void put_side_chunks(qs_writer *writer, const void *context)
{
    const qs_encoder *e = context;
    const qs_problem *problem = e->problem;
    const qs_grid *grid = &problem->grid;
    bool truncates = problem->pairwise.smoothness == QS_TRUNCATED_LINEAR ||
                     problem->pairwise.smoothness == QS_TRUNCATED_QUADRATIC;
    qs_labels labels = {
        .encoding = e->encoding,
        .pairwise = {.smoothness = problem->pairwise.smoothness,
                     .truncation = truncates ? problem->pairwise.truncation : 0},
        .penalty = e->penalty,
        .labels = problem->labels,
        .scale = problem->scale,
        .gap = (uint32_t)e->gap,
        .weight = (int32_t)(e->weight == QS_WEIGHT_UNSEEN ? 0 : e->weight),
        .width = grid->width,
        .height = grid->width > 0 ? grid->height : 0,
        .frame = problem->frame,
        .meaning = problem->meaning,
    };
    if (labels.frame.picture_width == 0) {
        labels.frame.picture_width = labels.width;
        labels.frame.picture_height = labels.height;
    }
    qs_put_labl(writer, &labels, grid->mask);
}

/* ---- Planning. ---- */

/* Returns true if a label is forbidden at any site. */
static bool forbids(const qs_problem *problem, uint32_t sites)
{
    size_t count = problem->allowed ? (size_t)sites * problem->labels : 0;
    for (size_t i = 0; i < count; i++) {
        if (problem->allowed[i] == 0) {
            return true;
        }
    }
    return false;
}

static qs_status choose(qs_encoder *e, const qs_encode_options *options)
{
    const qs_problem *problem = e->problem;
    qs_encode_options own;
    qs_status status = qs_encode_settle(options, &problem->pairwise, problem->labels, &own);
    if (status != QS_OK) {
        return status;
    }
    e->encoding = own.encoding;
    e->penalty = own.penalty;
    e->gap = own.gap;
    e->alpha = (uint64_t)own.alpha;
    bool streams = qs_encoding_facts_of(e->encoding)->is_streamed &&
                   !forbids(problem, (uint32_t)e->qcf.groups);
    bool known = qs_has_tables(e) || problem->pairwise.smoothness != QS_TABLES;
    return streams && known ? QS_OK : QS_E_ENCODING;
}

static qs_status make_plan(qs_encoder *e)
{
    e->qcf.variables = e->qcf.groups * e->problem->labels;
    if (!qs_plan_couplings(e)) {
        return QS_E_ARGUMENT;
    }
    qs_plan_costs(e);
    qs_plan_penalties(e);
    if (e->qcf.couplings > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    const uint64_t most = (uint64_t)QS_ENERGY_MAX;
    bool fits = e->magnitude <= most && e->weight_sum <= most && qs_band_sum(e) <= most &&
                e->block_max <= INT32_MAX;
    return fits ? QS_OK : QS_E_OVERFLOW;
}

static qs_status write_file(qs_encoder *e, const qs_sink *sink, uint64_t *size)
{
    e->qcf.group_runs = 1;
    e->qcf.put_group_runs = put_groups;
    e->qcf.put_blocks = qs_put_the_block;
    e->qcf.put_runs = qs_put_the_runs;
    e->qcf.put_linear = qs_put_the_costs;
    e->qcf.put_penalty_runs = qs_put_the_penalties;
    e->qcf.offset = e->offset;
    e->qcf.side_chunks = qs_labl_chunks(&e->problem->meaning);
    e->qcf.put_side_chunks = put_side_chunks;
    e->qcf.context = e;
    uint64_t written;
    qs_status status = qs_qcf_write(&e->qcf, sink, &written);
    if (status != QS_OK) {
        return status;
    }
    qs_grow(&e->magnitude, 1, qs_absolute(*e->offset));
    if (e->magnitude > (uint64_t)QS_ENERGY_MAX) {
        return QS_E_OVERFLOW;
    }
    if (size) {
        *size = written;
    }
    return QS_OK;
}

qs_status qs_encode(const qs_problem *problem, const qs_encode_options *options,
                    const qs_sink *sink, void *workspace, size_t workspace_size, uint64_t *size)
{
    qs_status status = qs_problem_check(problem);
    if (status != QS_OK) {
        return status;
    }
    if (!options || (!workspace && qs_encode_workspace(problem) > 0)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_encode_workspace(problem)) {
        return QS_E_WORKSPACE;
    }
    qs_problem own = *problem;
    int64_t offset = 0;
    qs_encoder e = {.problem = &own, .qcf.groups = qs_problem_sites(problem), .offset = &offset};
    if (e.qcf.groups == own.grid.width * own.grid.height) {
        own.grid.mask = NULL; /* it masks nothing: one problem, one string of bytes */
    }
    qs_arena arena = {.base = workspace};
    take_workspace(&arena, problem, &e);
    status = choose(&e, options);
    if (status == QS_OK) {
        status = make_plan(&e);
    }
    return status == QS_OK ? write_file(&e, sink, size) : status;
}
