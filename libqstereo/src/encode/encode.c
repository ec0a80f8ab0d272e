#include "../../include/qstereo/encode.h"

#include <stdbool.h>
#include <string.h>

#include "penalty.h"
#include "../base/bytes.h"
#include "../files/container.h"
#include "../problem/cost_strips.h"
#include "../problem/edge_runs.h"
#include "../problem/pairwise.h"
#include "../recode/remaining.h"
#include "../base/saturate.h"

enum { UNSEEN = -2 };

/* All that is settled before the first byte is written. */
typedef struct plan {
    const qs_problem *problem;
    qs_encoding encoding;
    qs_penalty penalty;
    uint64_t alpha, gap;
    uint32_t sites;
    int64_t *sums; /* of qs_reach_visit_all */
    int32_t *row_max; /* of a table: max over the columns of each row, */
    int32_t *col_max; /* and over the rows of each column */
    void *costs; /* workspace of the strips */
    int64_t block_max; /* largest pairwise cost */
    uint64_t block_sum; /* sum of the absolute entries of the block */
    uint32_t runs; /* of couplings */
    uint64_t runs_size; /* and their bytes */
    uint64_t couplings;
    uint64_t weight_sum;
    int64_t weight; /* of every edge, -1 where they differ, UNSEEN before the first */
    unsigned linear_bytes, penalty_bytes;
    uint64_t penalty_runs;
    uint64_t magnitude; /* M of docs/FORMAT.md without the offset, saturated */
    int64_t *offset; /* known when the linear terms have been written */
} plan;

static uint32_t labels_of(const plan *p)
{
    return p->problem->labels;
}

static bool sparse(const plan *p)
{
    return p->encoding == QS_ONE_HOT_SPARSE;
}

/* ---- Workspace: what the table and a list of edges need, then the costs. ---- */

static uint64_t sums_size(const qs_problem *problem)
{
    return problem->grid.width > 0 ? 0 : 2 * sizeof(int64_t) * (uint64_t)problem->sites;
}

static size_t maxima_size(const qs_problem *problem)
{
    return problem->pairwise.smoothness == QS_TABLE ? sizeof(int32_t) * problem->labels : 0;
}

size_t qs_encode_workspace(const qs_problem *problem)
{
    return qs_size(sums_size(problem) + 2 * maxima_size(problem) + qs_costs_workspace(problem));
}

static void lay_out(plan *p, void *workspace)
{
    char *at = workspace;
    p->sums = (int64_t *)(void *)at;
    p->row_max = (int32_t *)(void *)(at + sums_size(p->problem));
    p->col_max = p->row_max + maxima_size(p->problem) / sizeof(int32_t);
    p->costs = p->col_max + maxima_size(p->problem) / sizeof(int32_t);
}

/* ---- The block: V, or minus the band of one-hot-sparse. ---- */

static int64_t band(const plan *p)
{
    return qs_band(&p->problem->pairwise, labels_of(p));
}

/* The constant off-diagonal part: every entry whose labels are at least `reach` apart is `fill`. */
static int64_t toeplitz_fill(const plan *p, int64_t *reach)
{
    uint32_t labels = labels_of(p);
    if (sparse(p) || labels == 1) {
        *reach = sparse(p) && band(p) > 1 ? band(p) : 1;
        return 0;
    }
    int64_t fill = qs_pairwise_cost(p->problem, 0, labels - 1), d = 1;
    while (qs_pairwise_cost(p->problem, 0, (uint32_t)d) < fill) {
        d++;
    }
    *reach = d;
    return fill;
}

static int64_t toeplitz_entry(const plan *p, int64_t apart)
{
    return sparse(p) ? -qs_band_entry(band(p), apart)
                     : qs_pairwise_cost(p->problem, 0, (uint32_t)(apart < 0 ? -apart : apart));
}

static void put_block(qs_writer *writer, const void *context)
{
    const plan *p = context;
    uint32_t labels = labels_of(p);
    bool table = p->problem->pairwise.smoothness == QS_TABLE;
    qs_put_u32(writer, 1);
    qs_put_u32(writer, labels);
    qs_put_u32(writer, labels);
    qs_put_u32(writer, !table);
    if (table) {
        for (size_t i = 0; i < (size_t)labels * labels; i++) {
            qs_put_u32(writer, (uint32_t)p->problem->pairwise.table[i]);
        }
        return;
    }
    int64_t reach, fill = toeplitz_fill(p, &reach);
    qs_put_u32(writer, (uint32_t)fill);
    qs_put_u32(writer, (uint32_t)(1 - reach));
    qs_put_u32(writer, (uint32_t)(2 * reach - 1));
    for (int64_t apart = 1 - reach; apart < reach; apart++) {
        qs_put_u32(writer, (uint32_t)toeplitz_entry(p, apart));
    }
}

static void plan_toeplitz(plan *p)
{
    uint64_t labels = labels_of(p);
    int64_t reach, fill = toeplitz_fill(p, &reach);
    uint64_t cells = labels * labels;
    for (int64_t apart = 1 - reach; apart < reach; apart++) {
        uint64_t length = labels - (uint64_t)(apart < 0 ? -apart : apart);
        int64_t entry = toeplitz_entry(p, apart);
        qs_grow(&p->block_sum, length, (uint64_t)(entry < 0 ? -entry : entry));
        cells -= length;
    }
    qs_grow(&p->block_sum, cells, (uint64_t)fill);
    p->block_max = labels > 1 ? qs_pairwise_cost(p->problem, 0, (uint32_t)labels - 1) : 0;
}

static void plan_table(plan *p)
{
    uint32_t labels = labels_of(p);
    memset(p->row_max, 0, sizeof *p->row_max * labels);
    memset(p->col_max, 0, sizeof *p->col_max * labels);
    for (uint32_t a = 0; a < labels; a++) {
        for (uint32_t b = 0; b < labels; b++) {
            int32_t cost = p->problem->pairwise.table[(size_t)a * labels + b];
            p->row_max[a] = cost > p->row_max[a] ? cost : p->row_max[a];
            p->col_max[b] = cost > p->col_max[b] ? cost : p->col_max[b];
            p->block_max = cost > p->block_max ? cost : p->block_max;
            qs_grow(&p->block_sum, 1, (uint64_t)cost);
        }
    }
}

/* ---- The couplings. ---- */

/* Whether all weights of a run are the same, and the sum of them. */
static bool weigh(const qs_problem *problem, const qs_edge_run *run, uint64_t *sum,
                  int32_t *largest)
{
    int32_t one = qs_edge_weight(problem, run, 0, 0);
    bool same = true;
    *largest = one;
    *sum = (uint64_t)one * run->count * run->repeat; /* < 2^62 */
    if (!run->list && !run->weights) {
        return true;
    }
    *sum = 0;
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            int32_t weight = qs_edge_weight(problem, run, r, c);
            same &= weight == one;
            *largest = weight > *largest ? weight : *largest;
            *sum += (uint64_t)weight;
        }
    }
    return same;
}

enum { RUN_HEAD = 36 };

/* The weights are signed in the file. */
static unsigned weight_bytes(int32_t largest)
{
    return qs_bytes_of(2 * (uint64_t)largest);
}

static void plan_run(void *context, const qs_edge_run *run)
{
    plan *p = context;
    uint64_t sum;
    int32_t largest;
    bool same = weigh(p->problem, run, &sum, &largest);
    p->weight = !same || (p->weight != UNSEEN && p->weight != largest) ? -1 : largest;
    if (sum == 0) {
        return;
    }
    uint64_t pairs = (uint64_t)run->count * run->repeat;
    p->runs++;
    p->runs_size +=
        RUN_HEAD + (run->list ? 8 * pairs : 0) + (same ? 0 : pairs * weight_bytes(largest));
    p->couplings += pairs;
    p->weight_sum += sum;
    qs_grow(&p->magnitude, sum, p->block_sum);
}

typedef struct run_output {
    const plan *p;
    qs_writer *writer;
} run_output;

static void put_weights(const qs_problem *problem, qs_writer *writer, const qs_edge_run *run,
                        unsigned bytes)
{
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            qs_put_unsigned(writer, (uint32_t)qs_edge_weight(problem, run, r, c), bytes);
        }
    }
}

static void put_run(void *context, const qs_edge_run *run)
{
    const run_output *output = context;
    qs_writer *writer = output->writer;
    uint64_t sum;
    int32_t largest;
    bool same = weigh(output->p->problem, run, &sum, &largest);
    if (sum == 0) {
        return;
    }
    unsigned bytes = same ? 0 : weight_bytes(largest);
    uint32_t head[9] = {0,          run->list != NULL, bytes,      same ? (uint32_t)largest : 0,
                        run->first, run->second,       run->count, run->repeat,
                        run->stride};
    for (int i = 0; i < 9; i++) {
        qs_put_u32(writer, head[i]);
    }
    for (uint32_t e = 0; run->list && e < run->count; e++) {
        qs_put_u32(writer, run->list[e].first);
        qs_put_u32(writer, run->list[e].second);
    }
    if (!same) {
        put_weights(output->p->problem, writer, run, bytes);
    }
}

static void put_couplings(qs_writer *writer, const void *context)
{
    run_output output = {context, writer};
    qs_put_u32(writer, output.p->runs);
    qs_edges_visit(output.p->problem, put_run, &output);
}

/* ---- The penalties. ---- */

/* Gathers neighbouring sites of equal penalties into runs, which are written, or counted where
 * there is no writer. */
typedef struct penalty_runs {
    const plan *p;
    qs_writer *writer;
    uint64_t count, a, b; /* of the run under way */
    uint64_t ended, largest, magnitude;
} penalty_runs;

static void end_run(penalty_runs *runs)
{
    if (runs->count == 0) {
        return;
    }
    const plan *p = runs->p;
    uint64_t labels = labels_of(p);
    if (runs->writer) {
        qs_put_u32(runs->writer, (uint32_t)runs->count);
        qs_put_unsigned(runs->writer, runs->a, p->penalty_bytes);
        qs_put_unsigned(runs->writer, runs->b, p->penalty_bytes);
        return;
    }
    runs->ended++;
    runs->largest = runs->b > runs->largest ? runs->b : runs->largest;
    runs->largest = runs->a > runs->largest ? runs->a : runs->largest;
    qs_grow(&runs->magnitude, runs->a, runs->count * (1 + labels));
    qs_grow(&runs->magnitude, runs->b, runs->count * (labels * (labels - 1) / 2));
}

/* W: the most that a site's edges can cost, given the sums of their weights where it comes first
 * and second; saturated. */
static uint64_t reach_cost(const plan *p, uint64_t first, uint64_t second)
{
    uint64_t reach = 0;
    if (p->problem->pairwise.smoothness != QS_TABLE) {
        qs_grow(&reach, first + second, (uint64_t)p->block_max);
        return reach;
    }
    for (uint32_t d = 0; d < labels_of(p); d++) {
        uint64_t cost = 0;
        qs_grow(&cost, first, (uint64_t)p->row_max[d]);
        qs_grow(&cost, second, (uint64_t)p->col_max[d]);
        reach = cost > reach ? cost : reach;
    }
    return reach;
}

static void push_sites(void *context, uint32_t count, int64_t first, int64_t second)
{
    penalty_runs *runs = context;
    const plan *p = runs->p;
    uint64_t a = p->alpha, b = 2 * p->alpha;
    if (qs_penalty_keeps_gap(p->penalty)) {
        qs_site_edges edges = {(uint64_t)(first + second),
                               reach_cost(p, (uint64_t)first, (uint64_t)second)};
        qs_one_hot_bound(p->encoding, p->penalty, &p->problem->pairwise, labels_of(p), p->gap,
                         edges, &a, &b);
    }
    if (runs->count > 0 && (a != runs->a || b != runs->b)) {
        end_run(runs);
        runs->count = 0;
    }
    runs->count += count;
    runs->a = a;
    runs->b = b;
}

static penalty_runs visit_penalties(const plan *p, qs_writer *writer)
{
    penalty_runs runs = {.p = p, .writer = writer};
    if (qs_penalty_keeps_gap(p->penalty)) {
        qs_reach_visit_all(p->problem, p->sums, push_sites, &runs);
    } else {
        push_sites(&runs, p->sites, 0, 0);
    }
    end_run(&runs);
    return runs;
}

static void put_penalties(qs_writer *writer, const void *context)
{
    const plan *p = context;
    qs_put_u32(writer, p->penalty_bytes);
    qs_put_u32(writer, 0);
    visit_penalties(p, writer);
}

static void plan_penalties(plan *p)
{
    penalty_runs runs = visit_penalties(p, NULL);
    p->penalty_bytes = qs_bytes_of(runs.largest);
    p->penalty_runs = runs.ended;
    qs_grow(&p->magnitude, 1, runs.magnitude);
}

/* ---- The linear terms. ---- */

typedef struct survey {
    uint64_t largest, sum; /* of the shifted costs */
    uint64_t paper; /* sum of each site's largest cost, as in the paper's bound; saturated */
} survey;

static void survey_strip(survey *s, const qs_strip *strip, uint32_t labels)
{
    for (uint32_t i = 0; i < strip->sites; i++) {
        uint64_t largest = 0;
        for (uint32_t d = 0; d < labels; d++) {
            uint64_t cost = (uint64_t)qs_strip_cost(strip, (size_t)i * labels + d);
            largest = cost > largest ? cost : largest;
            s->sum += cost;
        }
        s->largest = largest > s->largest ? largest : s->largest;
        /* The paper's costs are never negative; where they are, only the shifted ones give a bound.
         */
        qs_grow(&s->paper, 1, largest + (strip->least[i] > 0 ? (uint64_t)strip->least[i] : 0));
    }
}

static survey survey_costs(const plan *p)
{
    survey s = {0};
    for (qs_strip strip = qs_strip_first(p->problem, p->costs); qs_strip_next(&strip);) {
        survey_strip(&s, &strip, labels_of(p));
    }
    return s;
}

/* Narrows a strip's costs, in place, to the file's width. */
static void narrow(const qs_strip *strip, size_t count, unsigned bytes)
{
    const uint32_t *wide = strip->costs;
    uint8_t *out = strip->costs;
    for (size_t i = 0; i < count; i++) {
        uint32_t cost = wide[i];
        if (bytes == 1) {
            out[i] = (uint8_t)cost;
        } else if (bytes == 2) {
            qs_store_u16(out + 2 * i, cost);
        } else {
            qs_store_u32(out + 4 * i, cost);
        }
    }
}

/* The costs make the offset on their way. */
static void put_linear(qs_writer *writer, const void *context)
{
    const plan *p = context;
    int64_t least_sum = 0; /* |sum| < 2^31 sites x 2^31 */
    qs_put_u64(writer, 0);
    qs_put_u32(writer, p->linear_bytes);
    qs_put_u32(writer, 0);
    for (qs_strip strip = qs_strip_first(p->problem, p->costs);
         !writer->failed && qs_strip_next(&strip);) {
        size_t count = (size_t)strip.sites * labels_of(p);
        if (strip.bytes == 4) {
            narrow(&strip, count, p->linear_bytes);
        }
        qs_put(writer, strip.costs, count * p->linear_bytes);
        least_sum += strip.least_sum;
    }
    *p->offset = least_sum + (sparse(p) ? (int64_t)p->weight_sum * band(p) : 0);
}

/* ---- The rest of the file. ---- */

static void put_groups(qs_writer *writer, const void *context)
{
    const plan *p = context;
    qs_put_u32(writer, p->sites);
    qs_put_u32(writer, labels_of(p));
}

static void put_offset(qs_writer *writer, const void *context)
{
    qs_put_u64(writer, (uint64_t)*((const plan *)context)->offset);
}

static void put_mask(qs_writer *writer, const qs_grid *grid)
{
    size_t cells = (size_t)grid->width * grid->height;
    for (size_t at = 0; at < cells; at += 8) {
        uint8_t byte = 0;
        for (size_t i = at; i < cells && i < at + 8; i++) {
            byte |= (uint8_t)((grid->mask[i] != 0) << (i - at));
        }
        qs_put(writer, &byte, 1);
    }
}

static void put_labels(qs_writer *writer, const void *context)
{
    const plan *p = context;
    const qs_problem *problem = p->problem;
    qs_frame frame = problem->frame;
    if (frame.picture_width == 0) {
        frame.picture_width = problem->grid.width;
        frame.picture_height = problem->grid.width > 0 ? problem->grid.height : 0;
    }
    bool truncates = problem->pairwise.smoothness == QS_TRUNCATED_LINEAR ||
                     problem->pairwise.smoothness == QS_TRUNCATED_QUADRATIC;
    qs_labels labels = {
        .encoding = p->encoding,
        .pairwise = {problem->pairwise.smoothness, truncates ? problem->pairwise.truncation : 0,
                     NULL},
        .penalty = p->penalty,
        .labels = problem->labels,
        .scale = problem->scale,
        .gap = (uint32_t)p->gap,
        .weight = (int32_t)(p->weight == UNSEEN ? 0 : p->weight),
        .width = problem->grid.width,
        .height = problem->grid.width > 0 ? problem->grid.height : 0,
        .frame = frame,
    };
    qs_put_labl_fields(writer, &labels, problem->grid.mask != NULL);
    if (problem->grid.mask) {
        put_mask(writer, &problem->grid);
    }
}

enum { CHUNKS = 7 };

static uint64_t block_size(const plan *p)
{
    uint64_t labels = labels_of(p);
    int64_t reach;
    if (p->problem->pairwise.smoothness == QS_TABLE) {
        return 4 + 12 + 4 * labels * labels;
    }
    toeplitz_fill(p, &reach);
    return 4 + 24 + 4 * (2 * (uint64_t)reach - 1);
}

static uint64_t labels_size(const plan *p)
{
    const qs_grid *grid = &p->problem->grid;
    return 64 + (grid->mask ? ((uint64_t)grid->width * grid->height + 7) / 8 : 0);
}

static void put_chunks(const plan *p, qs_writer *writer)
{
    uint64_t variables = (uint64_t)p->sites * labels_of(p);
    qs_put_chunk(writer, "GRPS", 8, put_groups, p);
    qs_put_chunk(writer, "BLKS", block_size(p), put_block, p);
    qs_put_chunk(writer, "CPLS", 4 + p->runs_size, put_couplings, p);
    qs_put_chunk(writer, "LINR", 16 + variables * p->linear_bytes, put_linear, p);
    qs_put_chunk(writer, "PNLT", 8 + p->penalty_runs * (4 + 2 * (uint64_t)p->penalty_bytes),
                 put_penalties, p);
    qs_put_chunk(writer, "OFFS", 8, put_offset, p);
    qs_put_chunk(writer, "labl", labels_size(p), put_labels, p);
}

/* ---- Planning. ---- */

static qs_status choose(plan *p, const qs_encode_options *options)
{
    qs_encode_options own;
    qs_status status = qs_encode_settle(options, &p->problem->pairwise, labels_of(p), &own);
    if (status != QS_OK) {
        return status;
    }
    p->encoding = own.encoding;
    p->penalty = own.penalty;
    p->gap = own.gap;
    p->alpha = (uint64_t)own.alpha;
    return qs_encoding_facts_of(p->encoding)->is_streamed ? QS_OK : QS_E_ENCODING;
}

/* The paper's alpha: above what any labelling costs. */
static void plan_alpha(plan *p, uint64_t costs)
{
    uint64_t bound = costs;
    qs_grow(&bound, p->weight_sum, (uint64_t)p->block_max);
    p->alpha = bound + 1;
}

static void plan_costs(plan *p)
{
    uint64_t variables = (uint64_t)p->sites * labels_of(p);
    survey s = {.largest = UINT8_MAX, .sum = variables * UINT8_MAX};
    bool bytes = !p->problem->costs && p->problem->source.bytes == 1;
    if (!bytes || p->penalty == QS_PENALTY_PAPER) {
        s = survey_costs(p);
    }
    p->linear_bytes = qs_bytes_of(s.largest);
    if (p->penalty == QS_PENALTY_PAPER) {
        plan_alpha(p, s.paper);
    }
    qs_grow(&p->magnitude, 1, s.sum);
}

static qs_status make_plan(plan *p)
{
    p->weight = UNSEEN;
    if (p->problem->pairwise.smoothness == QS_TABLE) {
        plan_table(p);
    } else {
        plan_toeplitz(p);
    }
    qs_edges_visit(p->problem, plan_run, p);
    if (p->problem->grid.width > 0 && !p->problem->grid.right) {
        p->weight = p->problem->weight; /* even where there is no edge */
    }
    plan_costs(p);
    plan_penalties(p);
    if (p->couplings > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    uint64_t most = (uint64_t)QS_ENERGY_MAX, band_sum = 0;
    if (sparse(p)) {
        qs_grow(&band_sum, p->weight_sum, (uint64_t)band(p));
    }
    return band_sum <= most && p->magnitude <= most && p->weight_sum <= most &&
                   p->block_max <= INT32_MAX
               ? QS_OK
               : QS_E_OVERFLOW;
}

static qs_status write_file(plan *p, const qs_sink *sink, uint64_t *size)
{
    int64_t offset = 0;
    qs_writer count = {0};
    p->offset = &offset;
    put_chunks(p, &count);
    uint8_t fields[36] = {0};
    qs_store_u32(fields, p->sites * labels_of(p));
    qs_store_u32(fields + 4, p->sites);
    qs_store_u64(fields + 8, p->couplings);
    qs_writer writer = qs_writer_to(sink);
    qs_put_header(&writer, QS_MAGIC_QCF, CHUNKS, QS_HEADER_SIZE + count.size, fields);
    put_chunks(p, &writer);
    qs_flush(&writer);
    if (writer.failed) {
        return QS_E_IO;
    }
    qs_grow(&p->magnitude, 1, (uint64_t)(offset < 0 ? -offset : offset));
    if (p->magnitude > (uint64_t)QS_ENERGY_MAX) {
        return QS_E_OVERFLOW;
    }
    if (size) {
        *size = writer.size;
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
    plan p = {.problem = &own, .sites = qs_problem_sites(problem)};
    if (p.sites == own.grid.width * own.grid.height) {
        own.grid.mask = NULL; /* it masks nothing: one problem, one string of bytes */
    }
    lay_out(&p, workspace);
    status = choose(&p, options);
    if (status == QS_OK) {
        status = make_plan(&p);
    }
    return status == QS_OK ? write_file(&p, sink, size) : status;
}
