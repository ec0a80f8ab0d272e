#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../problem/edge_runs.h"
#include "../problem/pairwise.h"
#include "encoder.h"

/* ---- The block. ---- */

static int64_t band(const qs_encoder *e)
{
    return qs_band(&e->problem->pairwise, e->problem->labels);
}

uint64_t qs_band_sum(const qs_encoder *e)
{
    uint64_t sum = 0;
    if (qs_is_sparse(e)) {
        qs_grow(&sum, e->weight_sum, (uint64_t)band(e));
    }
    return sum;
}

/* The entry of two labels. */
static int64_t toeplitz_entry(const qs_encoder *e, int64_t apart)
{
    return qs_is_sparse(e) ? -qs_band_entry(band(e), apart)
                           : qs_pairwise_cost(e->problem, 0, (uint32_t)qs_absolute(apart));
}

/* All entries of labels at least `reach` apart are `fill`. */
typedef struct far_part {
    int64_t fill, reach;
} far_part;

static far_part far_part_of(const qs_encoder *e)
{
    uint32_t labels = e->problem->labels;
    if (qs_is_sparse(e)) {
        return (far_part){0, qs_max_i64(band(e), 1)};
    }
    if (labels == 1) {
        return (far_part){0, 1};
    }
    far_part far = {qs_pairwise_cost(e->problem, 0, labels - 1), 1};
    while (qs_pairwise_cost(e->problem, 0, (uint32_t)far.reach) < far.fill) {
        far.reach++;
    }
    return far;
}

static void plan_toeplitz(qs_encoder *e)
{
    uint64_t labels = e->problem->labels, cells = labels * labels;
    far_part far = far_part_of(e);
    for (int64_t apart = 1 - far.reach; apart < far.reach; apart++) {
        uint64_t length = labels - qs_absolute(apart);
        qs_grow(&e->block_sum, length, qs_absolute(toeplitz_entry(e, apart)));
        cells -= length;
    }
    qs_grow(&e->block_sum, cells, (uint64_t)far.fill);
    e->block_max = labels > 1 ? qs_pairwise_cost(e->problem, 0, (uint32_t)labels - 1) : 0;
    e->qcf.blocks_size = QS_TOEPLITZ_HEAD + 4 * (2 * (uint64_t)far.reach - 1);
}

static void plan_table(qs_encoder *e)
{
    uint32_t labels = e->problem->labels;
    int32_t *of_row = e->largest, *of_column = of_row + labels;
    memset(e->largest, 0, sizeof *e->largest * 2 * labels);
    for (uint32_t a = 0; a < labels; a++) {
        for (uint32_t b = 0; b < labels; b++) {
            int32_t cost = e->problem->pairwise.table[(size_t)a * labels + b];
            of_row[a] = qs_max_i32(of_row[a], cost);
            of_column[b] = qs_max_i32(of_column[b], cost);
            e->block_max = qs_max_i64(e->block_max, cost);
            qs_grow(&e->block_sum, 1, (uint64_t)cost);
        }
    }
    e->qcf.blocks_size = QS_TABLE_HEAD + 4 * (uint64_t)labels * labels;
}

void qs_put_the_block(qs_writer *writer, const void *encoder)
{
    const qs_encoder *e = encoder;
    uint32_t labels = e->problem->labels;
    if (qs_has_tables(e)) {
        qs_put_the_tables(writer, e);
        return;
    }
    if (qs_has_table(e)) {
        qs_put_table_head(writer, labels, labels);
        for (size_t i = 0; i < (size_t)labels * labels; i++) {
            qs_put_entry(writer, e->problem->pairwise.table[i]);
        }
        return;
    }
    far_part far = far_part_of(e);
    uint32_t diagonals = (uint32_t)(2 * far.reach - 1);
    qs_put_toeplitz_head(writer, labels, labels, far.fill, 1 - far.reach, diagonals);
    for (int64_t apart = 1 - far.reach; apart < far.reach; apart++) {
        qs_put_entry(writer, toeplitz_entry(e, apart));
    }
}

/* ---- The couplings. ---- */

/* The sum of a run's weights, the largest, and whether all are the same. */
typedef struct weighed {
    uint64_t sum;
    int32_t largest;
    bool same;
} weighed;

static weighed weigh(const qs_problem *problem, const qs_edge_run *run)
{
    int32_t one = qs_edge_weight(problem, run, 0, 0);
    weighed w = {0, one, true};
    if (!run->list && !run->weights) {
        w.sum = (uint64_t)one * run->count * run->repeat; /* < 2^62 */
        return w;
    }
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            int32_t weight = qs_edge_weight(problem, run, r, c);
            w.same &= weight == one;
            w.largest = qs_max_i32(w.largest, weight);
            w.sum += (uint64_t)weight;
        }
    }
    return w;
}

static qs_run head_of(const qs_edge_run *run, const weighed *w)
{
    return (qs_run){
        .is_list = run->list != NULL,
        .weight_bytes = w->same ? 0 : qs_weight_bytes((uint32_t)w->largest),
        .weight = w->same ? w->largest : 0,
        .first = run->first,
        .second = run->second,
        .count = run->count,
        .repeat = run->repeat,
        .stride = run->stride,
    };
}

/* Notes the weight that all edges have, or that they differ. */
static void note_weight(qs_encoder *e, const weighed *w)
{
    bool alike = w->same && (e->weight == QS_WEIGHT_UNSEEN || e->weight == w->largest);
    e->weight = alike ? w->largest : -1;
}

static void weigh_run(void *context, const qs_edge_run *run)
{
    qs_encoder *e = context;
    weighed w = weigh(e->problem, run);
    note_weight(e, &w);
}

static void plan_run(void *context, const qs_edge_run *run)
{
    qs_encoder *e = context;
    weighed w = weigh(e->problem, run);
    note_weight(e, &w);
    if (w.sum == 0) {
        return;
    }
    qs_run head = head_of(run, &w);
    e->qcf.runs++;
    e->qcf.runs_size += qs_run_size(&head);
    e->qcf.couplings += qs_run_pairs(&head);
    e->weight_sum += w.sum;
    qs_grow(&e->magnitude, w.sum, e->block_sum);
}

static void plan_one_block(qs_encoder *e)
{
    e->qcf.blocks = 1;
    if (qs_has_table(e)) {
        plan_table(e);
    } else {
        plan_toeplitz(e);
    }
    qs_edges_visit(e->problem, plan_run, e);
    qs_grow(&e->edge_sum, e->weight_sum, (uint64_t)e->block_max);
}

bool qs_plan_couplings(qs_encoder *e)
{
    bool fits = true;
    e->weight = QS_WEIGHT_UNSEEN;
    if (qs_has_tables(e)) {
        qs_edges_visit(e->problem, weigh_run, e);
        fits = qs_plan_tables(e);
    } else {
        plan_one_block(e);
    }
    if (e->problem->grid.width > 0 && !e->problem->grid.right) {
        e->weight = e->problem->weight; /* also where the grid has no edge */
    }
    return fits;
}

typedef struct run_output {
    const qs_encoder *encoder;
    qs_writer *writer;
} run_output;

static void put_run(void *context, const qs_edge_run *run)
{
    const run_output *output = context;
    const qs_problem *problem = output->encoder->problem;
    qs_writer *writer = output->writer;
    weighed w = weigh(problem, run);
    if (w.sum == 0) {
        return;
    }
    qs_run head = head_of(run, &w);
    qs_put_run_head(writer, &head);
    uint32_t listed = run->list ? run->count : 0;
    for (uint32_t i = 0; i < listed; i++) {
        qs_put_pair(writer, run->list[i].first, run->list[i].second);
    }
    if (head.weight_bytes == 0) {
        return;
    }
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            uint32_t weight = (uint32_t)qs_edge_weight(problem, run, r, c);
            qs_put_unsigned(writer, weight, head.weight_bytes);
        }
    }
}

void qs_put_the_runs(qs_writer *writer, const void *encoder)
{
    run_output output = {encoder, writer};
    if (qs_has_tables(encoder)) {
        qs_put_table_runs(writer, encoder);
        return;
    }
    qs_edges_visit(output.encoder->problem, put_run, &output);
}
