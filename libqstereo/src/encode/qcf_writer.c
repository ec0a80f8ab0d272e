#include "qcf_writer.h"

#include <string.h>

#include "../base/bytes.h"
#include "../base/saturate.h"

enum { CHUNKS = 6, RUN_HEAD = 36, GROUP_RUN = 8 };

/* ---- Construction. ---- */

uint64_t qs_draft_workspace(qs_draft_sizes sizes)
{
    return sizes.variables * sizeof(int64_t) +
           sizes.runs * (sizeof(qs_penalty_run) + sizeof(qs_group_run)) +
           sizes.pairs * sizeof(qs_draft_pair);
}

qs_draft qs_draft_in(void *memory, qs_draft_sizes sizes)
{
    qs_draft draft = {.linear = memory};
    draft.penalty_runs = (qs_penalty_run *)(void *)(draft.linear + sizes.variables);
    draft.group_runs = (qs_group_run *)(void *)(draft.penalty_runs + sizes.runs);
    draft.pairs = (qs_draft_pair *)(void *)(draft.group_runs + sizes.runs);
    memset(draft.linear, 0, (size_t)sizes.variables * sizeof *draft.linear);
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
    return d->entry(d->blocks, block, apart < 0 ? (uint32_t)-apart : 0,
                    apart < 0 ? 0 : (uint32_t)apart);
}

/* The diagonals of a Toeplitz block that differ from its fill, from the first to the last; of a
 * single cell always that one. */
static uint32_t diagonals(const qs_draft *d, uint32_t block, const qs_block_shape *shape,
                          int64_t *first)
{
    int64_t from = 1 - (int64_t)shape->rows, to = shape->columns;
    bool cell = shape->rows == 1 && shape->columns == 1;
    while (!cell && from < to && diagonal_entry(d, block, from) == shape->fill) {
        from++;
    }
    while (!cell && from < to && diagonal_entry(d, block, to - 1) == shape->fill) {
        to--;
    }
    *first = from < to ? from : 0;
    return (uint32_t)(to - from);
}

static uint64_t block_size(const qs_draft *d, uint32_t block)
{
    qs_block_shape shape = d->shape(d->blocks, block);
    int64_t first;
    return shape.toeplitz ? 24 + 4 * (uint64_t)diagonals(d, block, &shape, &first)
                          : 12 + 4 * (uint64_t)shape.rows * shape.columns;
}

static void put_block(const qs_draft *d, qs_writer *writer, uint32_t block)
{
    qs_block_shape shape = d->shape(d->blocks, block);
    qs_put_u32(writer, shape.rows);
    qs_put_u32(writer, shape.columns);
    qs_put_u32(writer, shape.toeplitz);
    if (shape.toeplitz) {
        int64_t first;
        uint32_t count = diagonals(d, block, &shape, &first);
        qs_put_u32(writer, (uint32_t)shape.fill);
        qs_put_u32(writer, (uint32_t)first);
        qs_put_u32(writer, count);
        for (uint32_t i = 0; i < count; i++) {
            qs_put_u32(writer, (uint32_t)diagonal_entry(d, block, first + i));
        }
        return;
    }
    for (uint32_t row = 0; row < shape.rows; row++) {
        for (uint32_t column = 0; column < shape.columns; column++) {
            qs_put_u32(writer, (uint32_t)d->entry(d->blocks, block, row, column));
        }
    }
}

uint64_t qs_draft_block_sum(const qs_draft *d, uint32_t block)
{
    qs_block_shape shape = d->shape(d->blocks, block);
    int64_t rows = shape.rows, columns = shape.columns;
    uint64_t sum = 0;
    for (int64_t apart = 1 - rows; shape.toeplitz && apart < columns; apart++) {
        int64_t down = apart < 0 ? rows + apart : rows,
                across = apart < 0 ? columns : columns - apart;
        qs_grow(&sum, (uint64_t)(down < across ? down : across),
                qs_absolute(diagonal_entry(d, block, apart)));
    }
    for (uint32_t row = 0; !shape.toeplitz && row < shape.rows; row++) {
        for (uint32_t column = 0; column < shape.columns; column++) {
            qs_grow(&sum, 1, qs_absolute(d->entry(d->blocks, block, row, column)));
        }
    }
    return sum;
}

/* ---- Runs of couplings. ---- */

/* A run: pairs from `from` on, `size` of them. */
typedef struct run {
    size_t from, size;
    uint32_t count, repeat, stride;
    bool list;
    unsigned bytes; /* of each weight; 0 = all are the same */
    uint64_t sum; /* of the absolute weights */
} run;

/* Whether a run may go on into a pair. */
static bool goes_on(const qs_draft *d, size_t pair)
{
    return pair < d->pair_count && d->pairs[pair].block == (d->pairs[pair - 1].block & ~QS_NEW_RUN);
}

/* Pairs from one on of which both groups rise by one. */
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

/* The longest lattice from a pair on. */
static run lattice(const qs_draft *d, size_t from)
{
    const qs_draft_pair *pair = &d->pairs[from];
    run r = {.from = from, .count = stretch(d, from), .repeat = 1};
    r.size = r.count;
    while (goes_on(d, from + r.size)) {
        const qs_draft_pair *next = &pair[r.size];
        uint32_t stride = r.repeat == 1 ? next->first - pair->first : r.stride;
        bool regular = next->first > pair->first &&
                       next->first == pair->first + (uint64_t)r.repeat * stride &&
                       next->second == pair->second + (uint64_t)r.repeat * stride;
        if (!regular || stretch(d, from + r.size) != r.count) {
            break;
        }
        r.stride = stride;
        r.repeat++;
        r.size += r.count;
    }
    return r;
}

static void weigh(const qs_draft *d, run *r)
{
    const qs_draft_pair *pair = &d->pairs[r->from];
    uint32_t largest = 0;
    bool same = true;
    for (size_t i = 0; i < r->size; i++) {
        int32_t weight = pair[i].weight;
        uint32_t size = (uint32_t)(weight < 0 ? -(weight + 1) : weight);
        largest = size > largest ? size : largest;
        same &= weight == pair->weight;
        r->sum += qs_absolute(weight);
    }
    r->bytes = same ? 0 : qs_bytes_of(2 * (uint64_t)largest);
}

/* The run from a pair on: a lattice, or the list of all pairs before the next one that is worth a
 * run of its own. */
static run run_from(const qs_draft *d, size_t from)
{
    run r = lattice(d, from);
    if (r.size < d->lattice) {
        while (goes_on(d, from + r.size)) {
            size_t more = lattice(d, from + r.size).size;
            if (more >= d->lattice) {
                break;
            }
            r.size += more;
        }
        r.list = true;
        r.count = (uint32_t)r.size;
        r.repeat = 1;
        r.stride = 0;
    }
    weigh(d, &r);
    return r;
}

static void put_run(const qs_draft *d, qs_writer *writer, const run *r)
{
    const qs_draft_pair *pair = &d->pairs[r->from];
    uint32_t head[9] = {pair->block & ~QS_NEW_RUN,
                        r->list,
                        r->bytes,
                        r->bytes == 0 ? (uint32_t)pair->weight : 0,
                        r->list ? 0 : pair->first,
                        r->list ? 0 : pair->second,
                        r->count,
                        r->repeat,
                        r->stride};
    for (int i = 0; i < 9; i++) {
        qs_put_u32(writer, head[i]);
    }
    for (size_t i = 0; r->list && i < r->size; i++) {
        qs_put_u32(writer, pair[i].first);
        qs_put_u32(writer, pair[i].second);
    }
    for (size_t i = 0; r->bytes > 0 && i < r->size; i++) {
        qs_put_unsigned(writer, (uint32_t)pair[i].weight, r->bytes);
    }
}

/* ---- The file. ---- */

/* What is settled before the first byte is written. */
typedef struct plan {
    const qs_draft *draft;
    uint64_t blocks_size, runs_size, couplings;
    uint32_t runs;
    int64_t base; /* of the linear terms */
    unsigned linear_bytes, penalty_bytes;
    uint64_t magnitude; /* M of docs/FORMAT.md, saturated */
} plan;

static void plan_couplings(plan *p)
{
    const qs_draft *d = p->draft;
    uint64_t sum = 0;
    uint32_t block = UINT32_MAX;
    run r;
    for (size_t at = 0; at < d->pair_count; at += r.size) {
        r = run_from(d, at);
        if (r.sum == 0) {
            continue;
        }
        if (block != (d->pairs[at].block & ~QS_NEW_RUN)) {
            block = d->pairs[at].block & ~QS_NEW_RUN;
            sum = qs_draft_block_sum(d, block);
        }
        p->runs++;
        p->runs_size += RUN_HEAD + (r.list ? 8 * (uint64_t)r.size : 0) + (uint64_t)r.size * r.bytes;
        p->couplings += r.size;
        qs_grow(&p->magnitude, r.sum, sum);
    }
}

static void plan_linear(plan *p)
{
    const qs_draft *d = p->draft;
    int64_t least = d->variables > 0 ? INT64_MAX : 0, largest = least;
    for (uint64_t i = 0; i < d->variables; i++) {
        least = d->linear[i] < least ? d->linear[i] : least;
        largest = i == 0 || d->linear[i] > largest ? d->linear[i] : largest;
        qs_grow(&p->magnitude, 1, qs_absolute(d->linear[i]));
    }
    p->base = least;
    p->linear_bytes = qs_bytes_of((uint64_t)(largest - least));
}

/* Groups and penalties side by side, in pieces of one size and one pair each. */
static void plan_penalties(plan *p)
{
    const qs_draft *d = p->draft;
    uint64_t largest = 0;
    const qs_group_run *groups = d->group_runs;
    uint64_t passed = 0;
    for (size_t r = 0; r < d->penalty_run_count; r++) {
        const qs_penalty_run *penalty = &d->penalty_runs[r];
        largest = penalty->a > largest ? penalty->a : largest;
        largest = penalty->b > largest ? penalty->b : largest;
        for (uint64_t left = penalty->count; left > 0;) {
            uint64_t count = groups->count - passed < left ? groups->count - passed : left,
                     size = groups->size;
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
    p->penalty_bytes = qs_bytes_of(largest);
}

static plan make_plan(const qs_draft *draft)
{
    plan p = {.draft = draft};
    for (uint32_t block = 0; block < draft->block_count; block++) {
        p.blocks_size += block_size(draft, block);
    }
    plan_couplings(&p);
    plan_linear(&p);
    plan_penalties(&p);
    qs_grow(&p.magnitude, 1, qs_absolute(draft->offset));
    return p;
}

static void put_groups(qs_writer *writer, const void *context)
{
    const qs_draft *d = ((const plan *)context)->draft;
    for (size_t r = 0; r < d->group_run_count; r++) {
        qs_put_u32(writer, d->group_runs[r].count);
        qs_put_u32(writer, d->group_runs[r].size);
    }
}

static void put_blocks(qs_writer *writer, const void *context)
{
    const qs_draft *d = ((const plan *)context)->draft;
    qs_put_u32(writer, d->block_count);
    for (uint32_t block = 0; block < d->block_count; block++) {
        put_block(d, writer, block);
    }
}

static void put_couplings(qs_writer *writer, const void *context)
{
    const plan *p = context;
    run r;
    qs_put_u32(writer, p->runs);
    for (size_t at = 0; at < p->draft->pair_count; at += r.size) {
        r = run_from(p->draft, at);
        if (r.sum > 0) {
            put_run(p->draft, writer, &r);
        }
    }
}

static void put_linear(qs_writer *writer, const void *context)
{
    const plan *p = context;
    qs_put_u64(writer, (uint64_t)p->base);
    qs_put_u32(writer, p->linear_bytes);
    qs_put_u32(writer, 0);
    for (uint64_t i = 0; i < p->draft->variables; i++) {
        qs_put_unsigned(writer, (uint64_t)(p->draft->linear[i] - p->base), p->linear_bytes);
    }
}

static void put_penalties(qs_writer *writer, const void *context)
{
    const plan *p = context;
    qs_put_u32(writer, p->penalty_bytes);
    qs_put_u32(writer, 0);
    for (size_t r = 0; r < p->draft->penalty_run_count; r++) {
        const qs_penalty_run *penalty = &p->draft->penalty_runs[r];
        qs_put_u32(writer, penalty->count);
        qs_put_unsigned(writer, penalty->a, p->penalty_bytes);
        qs_put_unsigned(writer, penalty->b, p->penalty_bytes);
    }
}

static void put_offset(qs_writer *writer, const void *context)
{
    qs_put_u64(writer, (uint64_t)((const plan *)context)->draft->offset);
}

static void put_chunks(const plan *p, qs_writer *writer)
{
    const qs_draft *d = p->draft;
    qs_put_chunk(writer, "GRPS", (uint64_t)d->group_run_count * GROUP_RUN, put_groups, p);
    qs_put_chunk(writer, "BLKS", 4 + p->blocks_size, put_blocks, p);
    qs_put_chunk(writer, "CPLS", 4 + p->runs_size, put_couplings, p);
    qs_put_chunk(writer, "LINR", 16 + d->variables * p->linear_bytes, put_linear, p);
    qs_put_chunk(writer, "PNLT", 8 + d->penalty_run_count * (4 + 2 * (uint64_t)p->penalty_bytes),
                 put_penalties, p);
    qs_put_chunk(writer, "OFFS", 8, put_offset, p);
}

qs_status qs_draft_write(const qs_draft *draft, uint32_t side_count, qs_side_chunks *side,
                         const void *context, const qs_sink *sink, uint64_t *size)
{
    plan p = make_plan(draft);
    if (draft->overflow || p.magnitude > (uint64_t)QS_ENERGY_MAX) {
        return QS_E_OVERFLOW;
    }
    if (draft->variables > QS_VARIABLES_MAX || p.couplings > QS_VARIABLES_MAX) {
        return QS_E_LIMIT;
    }
    qs_writer count = {0};
    put_chunks(&p, &count);
    side(&count, context);
    uint8_t fields[36] = {0};
    qs_store_u32(fields, (uint32_t)draft->variables);
    qs_store_u32(fields + 4, (uint32_t)draft->groups);
    qs_store_u64(fields + 8, p.couplings);
    qs_writer writer = qs_writer_to(sink);
    qs_put_header(&writer, QS_MAGIC_QCF, CHUNKS + side_count, QS_HEADER_SIZE + count.size, fields);
    put_chunks(&p, &writer);
    side(&writer, context);
    qs_flush(&writer);
    if (writer.failed) {
        return QS_E_IO;
    }
    if (size) {
        *size = writer.size;
    }
    return QS_OK;
}
