#include "draft.h"

#include <string.h>

#include "../base/bytes.h"
#include "../base/minmax.h"

/* ---- Construction. ---- */

qs_draft qs_draft_take(qs_arena *arena, qs_draft_sizes sizes)
{
    qs_draft draft = {
        .linear = qs_arena_take(arena, sizes.variables, sizeof(int64_t)),
        .penalty_runs = qs_arena_take(arena, sizes.runs, sizeof(qs_penalty_run)),
        .group_runs = qs_arena_take(arena, sizes.runs, sizeof(qs_group_run)),
        .pairs = qs_arena_take(arena, sizes.pairs, sizeof(qs_draft_pair)),
    };
    if (draft.linear) {
        memset(draft.linear, 0, (size_t)sizes.variables * sizeof *draft.linear);
    }
    return draft;
}

void qs_draft_groups(qs_draft *draft, uint32_t count, uint32_t size, uint64_t a, uint64_t b)
{
    qs_group_run *groups = &draft->group_runs[draft->group_run_count];
    qs_penalty_run *penalty = &draft->penalty_runs[draft->penalty_run_count];
    if (draft->group_run_count > 0 && groups[-1].size == size) {
        groups[-1].count += count;
    } else {
        *groups = (qs_group_run){count, size};
        draft->group_run_count++;
    }
    if (draft->penalty_run_count > 0 && penalty[-1].a == a && penalty[-1].b == b) {
        penalty[-1].count += count;
    } else {
        *penalty = (qs_penalty_run){a, b, count};
        draft->penalty_run_count++;
    }
    draft->groups += count;
    draft->variables += (uint64_t)count * size;
}

void qs_draft_couple(qs_draft *draft, uint32_t first, uint32_t second, uint32_t block,
                     int64_t weight)
{
    draft->overflow |= weight > INT32_MAX || weight < INT32_MIN;
    draft->pairs[draft->pair_count++] = (qs_draft_pair){first, second, block, (int32_t)weight};
}

/* ---- Blocks. ---- */

static int64_t diagonal_entry(const qs_draft *d, uint32_t block, int64_t apart)
{
    return apart < 0 ? d->entry(d->blocks, block, (uint32_t)-apart, 0)
                     : d->entry(d->blocks, block, 0, (uint32_t)apart);
}

/* Diagonals of a Toeplitz block: `count` of them from column - row = first on. */
typedef struct band {
    int64_t first;
    uint32_t count;
} band;

/* The diagonals from the first to the last that differs from the block's fill; of a single cell
 * always that one. */
static band band_of(const qs_draft *d, uint32_t block, const qs_block_shape *shape)
{
    int64_t from = 1 - (int64_t)shape->rows, to = shape->columns;
    if (shape->rows == 1 && shape->columns == 1) {
        return (band){0, 1};
    }
    while (from < to && diagonal_entry(d, block, from) == shape->fill) {
        from++;
    }
    while (from < to && diagonal_entry(d, block, to - 1) == shape->fill) {
        to--;
    }
    return (band){from < to ? from : 0, (uint32_t)(to - from)};
}

static uint64_t block_size(const qs_draft *d, uint32_t block)
{
    qs_block_shape shape = d->shape(d->blocks, block);
    return shape.toeplitz ? QS_TOEPLITZ_HEAD + 4 * (uint64_t)band_of(d, block, &shape).count
                          : QS_TABLE_HEAD + 4 * (uint64_t)shape.rows * shape.columns;
}

static void put_block(const qs_draft *d, qs_writer *writer, uint32_t block)
{
    qs_block_shape shape = d->shape(d->blocks, block);
    if (shape.toeplitz) {
        band b = band_of(d, block, &shape);
        qs_put_toeplitz_head(writer, shape.rows, shape.columns, shape.fill, b.first, b.count);
        for (uint32_t i = 0; i < b.count; i++) {
            qs_put_entry(writer, diagonal_entry(d, block, b.first + i));
        }
        return;
    }
    qs_put_table_head(writer, shape.rows, shape.columns);
    for (uint32_t row = 0; row < shape.rows; row++) {
        for (uint32_t column = 0; column < shape.columns; column++) {
            qs_put_entry(writer, d->entry(d->blocks, block, row, column));
        }
    }
}

static uint64_t toeplitz_sum(const qs_draft *d, uint32_t block, const qs_block_shape *shape)
{
    int64_t rows = shape->rows, columns = shape->columns;
    uint64_t sum = 0;
    for (int64_t apart = 1 - rows; apart < columns; apart++) {
        int64_t down = apart < 0 ? rows + apart : rows,
                across = apart < 0 ? columns : columns - apart;
        qs_grow(&sum, (uint64_t)qs_min_i64(down, across),
                qs_absolute(diagonal_entry(d, block, apart)));
    }
    return sum;
}

uint64_t qs_draft_block_sum(const qs_draft *d, uint32_t block)
{
    qs_block_shape shape = d->shape(d->blocks, block);
    if (shape.toeplitz) {
        return toeplitz_sum(d, block, &shape);
    }
    uint64_t sum = 0;
    for (uint32_t row = 0; row < shape.rows; row++) {
        for (uint32_t column = 0; column < shape.columns; column++) {
            qs_grow(&sum, 1, qs_absolute(d->entry(d->blocks, block, row, column)));
        }
    }
    return sum;
}

/* ---- Runs of couplings. ---- */

/* A run: `size` pairs from `from` on. */
typedef struct run {
    size_t from, size;
    qs_run head;
    uint64_t sum; /* of the absolute weights */
} run;

static uint32_t block_of(const qs_draft *d, size_t pair)
{
    return d->pairs[pair].block & ~QS_NEW_RUN;
}

/* Returns true if a run may go on into a pair from the one before it. */
static bool goes_on(const qs_draft *d, size_t pair)
{
    return pair < d->pair_count && d->pairs[pair].block == block_of(d, pair - 1);
}

/* How many pairs from one on there are in which both groups rise by one. */
static uint32_t stretch(const qs_draft *d, size_t from)
{
    const qs_draft_pair *pair = &d->pairs[from];
    uint32_t count = 1;
    while (goes_on(d, from + count) && pair[count].first == pair->first + count &&
           pair[count].second == pair->second + count) {
        count++;
    }
    return count;
}

/* Returns true if `next` continues a lattice that begins with `pair` as its repetition `repeat`. */
static bool repeats(const qs_draft_pair *pair, const qs_draft_pair *next, uint64_t repeat,
                    uint32_t stride)
{
    return next->first > pair->first && next->first == pair->first + repeat * stride &&
           next->second == pair->second + repeat * stride;
}

/* The longest lattice from a pair on. */
static run lattice(const qs_draft *d, size_t from)
{
    const qs_draft_pair *pair = &d->pairs[from];
    run r = {.from = from};
    r.head = (qs_run){.block = block_of(d, from),
                      .first = pair->first,
                      .second = pair->second,
                      .count = stretch(d, from),
                      .repeat = 1};
    r.size = r.head.count;
    while (goes_on(d, from + r.size)) {
        const qs_draft_pair *next = &pair[r.size];
        uint32_t stride = r.head.repeat == 1 ? next->first - pair->first : r.head.stride;
        if (!repeats(pair, next, r.head.repeat, stride) ||
            stretch(d, from + r.size) != r.head.count) {
            break;
        }
        r.head.stride = stride;
        r.head.repeat++;
        r.size += r.head.count;
    }
    return r;
}

/* The list of all pairs from a run on that is not worth a lattice, before the next one that is. */
static void make_list(const qs_draft *d, run *r)
{
    while (goes_on(d, r->from + r->size)) {
        size_t more = lattice(d, r->from + r->size).size;
        if (more >= d->lattice) {
            break;
        }
        r->size += more;
    }
    r->head =
        (qs_run){.block = r->head.block, .is_list = true, .count = (uint32_t)r->size, .repeat = 1};
}

static void weigh(const qs_draft *d, run *r)
{
    const qs_draft_pair *pair = &d->pairs[r->from];
    uint32_t largest = 0;
    bool same = true;
    for (size_t i = 0; i < r->size; i++) {
        int32_t weight = pair[i].weight;
        largest = qs_max_u32(largest, (uint32_t)(weight < 0 ? -(weight + 1) : weight));
        same &= weight == pair->weight;
        r->sum += qs_absolute(weight);
    }
    r->head.weight = same ? pair->weight : 0;
    r->head.weight_bytes = same ? 0 : qs_weight_bytes(largest);
}

/* The run from a pair on. */
static run run_from(const qs_draft *d, size_t from)
{
    run r = lattice(d, from);
    if (r.size < d->lattice) {
        make_list(d, &r);
    }
    weigh(d, &r);
    return r;
}

static void put_run(const qs_draft *d, qs_writer *writer, const run *r)
{
    const qs_draft_pair *pair = &d->pairs[r->from];
    size_t listed = r->head.is_list ? r->size : 0, weights = r->head.weight_bytes > 0 ? r->size : 0;
    qs_put_run_head(writer, &r->head);
    for (size_t i = 0; i < listed; i++) {
        qs_put_pair(writer, pair[i].first, pair[i].second);
    }
    for (size_t i = 0; i < weights; i++) {
        qs_put_unsigned(writer, (uint32_t)pair[i].weight, r->head.weight_bytes);
    }
}

/* ---- Planning. ---- */

/* What is settled before the first byte is written. */
typedef struct plan {
    const qs_draft *draft;
    qs_qcf qcf;
    uint64_t magnitude; /* M of docs/FORMAT.md, saturated */
    qs_payload *put_side;
    const void *side;
} plan;

static void plan_couplings(plan *p)
{
    const qs_draft *d = p->draft;
    uint64_t sum = 0;
    uint32_t block = UINT32_MAX; /* whose sum it is */
    for (size_t at = 0; at < d->pair_count;) {
        run r = run_from(d, at);
        at += r.size;
        if (r.sum == 0) {
            continue;
        }
        if (block != r.head.block) {
            block = r.head.block;
            sum = qs_draft_block_sum(d, block);
        }
        p->qcf.runs++;
        p->qcf.runs_size += qs_run_size(&r.head);
        p->qcf.couplings += r.size;
        qs_grow(&p->magnitude, r.sum, sum);
    }
}

static void plan_linear(plan *p)
{
    const qs_draft *d = p->draft;
    int64_t least = d->variables > 0 ? d->linear[0] : 0, largest = least;
    for (uint64_t i = 0; i < d->variables; i++) {
        least = qs_min_i64(least, d->linear[i]);
        largest = qs_max_i64(largest, d->linear[i]);
        qs_grow(&p->magnitude, 1, qs_absolute(d->linear[i]));
    }
    p->qcf.linear_base = least;
    p->qcf.linear_bytes = qs_bytes_of((uint64_t)(largest - least));
}

/* Groups and penalties side by side, in pieces of one size and one pair (a, b) each. */
static void plan_penalties(plan *p)
{
    const qs_draft *d = p->draft;
    uint64_t largest = 0, passed = 0; /* groups of their run that are done */
    const qs_group_run *groups = d->group_runs;
    for (size_t r = 0; r < d->penalty_run_count; r++) {
        const qs_penalty_run *penalty = &d->penalty_runs[r];
        largest = qs_max_u64(largest, qs_max_u64(penalty->a, penalty->b));
        for (uint64_t left = penalty->count; left > 0;) {
            uint64_t count = qs_min_u64(groups->count - passed, left), size = groups->size;
            qs_grow(&p->magnitude, penalty->a, count * (1 + size));
            qs_grow(&p->magnitude, penalty->b, count * (size * (size - 1) / 2));
            left -= count;
            passed += count;
            if (passed == groups->count) {
                groups++;
                passed = 0;
            }
        }
    }
    p->qcf.penalty_bytes = qs_bytes_of(largest);
}

/* ---- The file. ---- */

static void put_groups(qs_writer *writer, const void *context)
{
    const qs_draft *d = ((const plan *)context)->draft;
    for (size_t r = 0; r < d->group_run_count; r++) {
        qs_put_group_run(writer, d->group_runs[r]);
    }
}

static void put_blocks(qs_writer *writer, const void *context)
{
    const qs_draft *d = ((const plan *)context)->draft;
    for (uint32_t block = 0; block < d->block_count; block++) {
        put_block(d, writer, block);
    }
}

static void put_runs(qs_writer *writer, const void *context)
{
    const qs_draft *d = ((const plan *)context)->draft;
    for (size_t at = 0; at < d->pair_count;) {
        run r = run_from(d, at);
        at += r.size;
        if (r.sum > 0) {
            put_run(d, writer, &r);
        }
    }
}

static void put_linear(qs_writer *writer, const void *context)
{
    const plan *p = context;
    for (uint64_t i = 0; i < p->draft->variables; i++) {
        uint64_t above = (uint64_t)(p->draft->linear[i] - p->qcf.linear_base);
        qs_put_unsigned(writer, above, p->qcf.linear_bytes);
    }
}

static void put_penalties(qs_writer *writer, const void *context)
{
    const plan *p = context;
    for (size_t r = 0; r < p->draft->penalty_run_count; r++) {
        qs_put_penalty_run(writer, &p->draft->penalty_runs[r], p->qcf.penalty_bytes);
    }
}

static void put_side_chunks(qs_writer *writer, const void *context)
{
    const plan *p = context;
    p->put_side(writer, p->side);
}

static plan make_plan(const qs_draft *draft)
{
    plan p = {.draft = draft};
    p.qcf = (qs_qcf){
        .variables = draft->variables,
        .groups = draft->groups,
        .group_runs = draft->group_run_count,
        .put_group_runs = put_groups,
        .blocks = draft->block_count,
        .put_blocks = put_blocks,
        .put_runs = put_runs,
        .put_linear = put_linear,
        .penalty_runs = draft->penalty_run_count,
        .put_penalty_runs = put_penalties,
        .offset = &draft->offset,
        .put_side_chunks = put_side_chunks,
    };
    for (uint32_t block = 0; block < draft->block_count; block++) {
        p.qcf.blocks_size += block_size(draft, block);
    }
    plan_couplings(&p);
    plan_linear(&p);
    plan_penalties(&p);
    qs_grow(&p.magnitude, 1, qs_absolute(draft->offset));
    return p;
}

qs_status qs_draft_write(const qs_draft *draft, uint32_t side_count, qs_payload *put_side,
                         const void *context, const qs_sink *sink, uint64_t *size)
{
    plan p = make_plan(draft);
    if (draft->overflow || p.magnitude > (uint64_t)QS_ENERGY_MAX) {
        return QS_E_OVERFLOW;
    }
    if (draft->variables > QS_VARIABLES_MAX || p.qcf.couplings > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    p.qcf.side_chunks = side_count;
    p.qcf.context = &p;
    p.put_side = put_side;
    p.side = context;
    return qs_qcf_write(&p.qcf, sink, size);
}
