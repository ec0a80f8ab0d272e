#include "../../include/qstereo/qubo.h"

#include <string.h>

#include "blocks.h"
#include "../base/bytes.h"
#include "../files/container.h"
#include "qcf_labels.h"

enum {
    GROUP_RUN = 8,
    COUPLING_RUN = 36,
    COUPLINGS_PER_BYTE = 16 /* of the file: so a small file cannot ask for long work */
};

/* What is needed while a file is checked. */
typedef struct opening {
    qs_reader reader;
    qs_qubo qubo;
    uint64_t magnitude; /* M of docs/FORMAT.md */
    uint64_t memory_limit;
} opening;

static bool corrupt(opening *o, uint64_t offset, const char *what)
{
    return qs_reject(&o->reader, QS_E_CORRUPT, offset, what);
}

/* magnitude += x * y; false where it would pass QS_ENERGY_MAX. */
static bool grow(opening *o, uint64_t x, uint64_t y)
{
    if (x != 0 && y > ((uint64_t)QS_ENERGY_MAX - o->magnitude) / x) {
        return false;
    }
    o->magnitude += x * y;
    return true;
}

static uint64_t absolute(int64_t value)
{
    return value < 0 ? -(uint64_t)value : (uint64_t)value;
}

static bool all_zero(const uint8_t *bytes, size_t size)
{
    uint8_t any = 0;
    for (size_t i = 0; i < size; i++) {
        any |= bytes[i];
    }
    return any == 0;
}

static bool is_width(uint32_t bytes)
{
    return bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8;
}

/* Parts of the workspace, the most aligned first. In 64 bits: what a header claims may not fit a
 * size_t. */
typedef struct layout {
    uint64_t block_at, start, near_start, penalty_run, near, end;
} layout;

static layout lay_out(const qs_qubo *q)
{
    uint64_t groups = q->groups;
    layout l = {0};
    l.start = l.block_at + q->block_count * (uint64_t)sizeof(size_t);
    l.near_start = l.start + (groups + 1) * sizeof(uint32_t);
    l.penalty_run = l.near_start + (groups + 1) * sizeof(uint32_t);
    l.near = l.penalty_run + groups * sizeof(uint32_t);
    l.end = l.near + 2 * q->couplings * sizeof(qs_neighbour);
    return l;
}

static bool within_memory(opening *o)
{
    return lay_out(&o->qubo).end <= (o->memory_limit < SIZE_MAX ? o->memory_limit : SIZE_MAX - 1) ||
           qs_reject(&o->reader, QS_E_LIMIT, QS_HEADER_FIELDS,
                     "memory for its groups and couplings");
}

static bool read_fields(opening *o)
{
    const uint8_t *fields = o->reader.bytes + QS_HEADER_FIELDS;
    qs_qubo *q = &o->qubo;
    q->variables = qs_load_u32(fields);
    q->groups = qs_load_u32(fields + 4);
    q->couplings = qs_load_u64(fields + 8);
    if (q->variables > QS_VARIABLES_MAX || q->groups > q->variables ||
        (q->groups == 0) != (q->variables == 0) || q->couplings > QS_VARIABLES_MAX) {
        return corrupt(o, QS_HEADER_FIELDS, "counts of the header");
    }
    if (!all_zero(fields + 16, 20)) {
        return corrupt(o, QS_HEADER_FIELDS + 16, "reserved bytes of the header");
    }
    return within_memory(o);
}

static bool read_groups(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "GRPS", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    uint64_t groups = 0, variables = 0;
    uint32_t before = 0;
    q->group_runs = chunk.payload;
    q->group_run_count = (size_t)(chunk.length / GROUP_RUN);
    for (size_t r = 0; r < q->group_run_count; r++) {
        uint32_t count = qs_load_u32(q->group_runs + r * GROUP_RUN),
                 size = qs_load_u32(q->group_runs + r * GROUP_RUN + 4);
        groups += count;
        variables += (uint64_t)count * size;
        if (count == 0 || size == 0 || size == before || groups > q->groups ||
            variables > q->variables) {
            return corrupt(o, chunk.offset + r * GROUP_RUN, "a run of groups");
        }
        before = size;
    }
    return (chunk.length % GROUP_RUN == 0 && groups == q->groups && variables == q->variables) ||
           corrupt(o, chunk.offset, "number of groups or variables");
}

static bool read_blocks(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "BLKS", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    q->blocks = chunk.payload;
    uint64_t at = 4;
    if (chunk.length < at) {
        return corrupt(o, chunk.offset, "length of BLKS");
    }
    q->block_count = qs_load_u32(chunk.payload);
    for (uint32_t b = 0; b < q->block_count; b++) {
        uint64_t size = qs_block_size(chunk.payload + at, chunk.length - at);
        if (size == 0) {
            return corrupt(o, chunk.offset + at, "a block");
        }
        at += size;
    }
    return at == chunk.length ? within_memory(o) : corrupt(o, chunk.offset + at, "length of BLKS");
}

/* The block of the run under way. Indices never fall, so that all blocks are gone through once. */
typedef struct block_cursor {
    const uint8_t *at;
    uint32_t block;
    qs_block_facts whole, upper;
} block_cursor;

static void seek_block(const qs_qubo *q, block_cursor *cursor, uint32_t block)
{
    if (cursor->at && cursor->block == block) {
        return;
    }
    if (!cursor->at) {
        cursor->at = q->blocks + 4;
    }
    for (; cursor->block < block; cursor->block++) {
        cursor->at += qs_block_size(cursor->at, UINT64_MAX);
    }
    cursor->whole = qs_block_summary(cursor->at);
    cursor->upper = qs_block_upper(cursor->at);
}

/* A run of couplings, decoded. */
typedef struct coupling_run {
    uint32_t block, form, bytes, first, second, count, repeat, stride;
    int32_t weight;
    const uint8_t *pairs, *weights; /* of a list; where the weights differ */
    uint64_t size; /* in the file */
} coupling_run;

static coupling_run load_run(const uint8_t *at)
{
    coupling_run run = {
        .block = qs_load_u32(at), .form = qs_load_u32(at + 4), .bytes = qs_load_u32(at + 8)};
    run.weight = qs_load_i32(at + 12);
    run.first = qs_load_u32(at + 16);
    run.second = qs_load_u32(at + 20);
    run.count = qs_load_u32(at + 24);
    run.repeat = qs_load_u32(at + 28);
    run.stride = qs_load_u32(at + 32);
    uint64_t listed = run.form == 1 ? 8 * (uint64_t)run.count : 0;
    run.pairs = at + COUPLING_RUN;
    run.weights = run.pairs + listed;
    run.size = COUPLING_RUN + listed + (uint64_t)run.count * run.repeat * run.bytes;
    return run;
}

static void run_pair(const coupling_run *run, uint32_t r, uint32_t c, uint32_t *first,
                     uint32_t *second)
{
    if (run->form == 1) {
        *first = qs_load_u32(run->pairs + 8 * (size_t)c);
        *second = qs_load_u32(run->pairs + 8 * (size_t)c + 4);
    } else {
        *first = run->first + r * run->stride + c;
        *second = run->second + r * run->stride + c;
    }
}

static int32_t run_weight(const coupling_run *run, uint32_t r, uint32_t c)
{
    return run->bytes == 0
               ? run->weight
               : qs_load_signed(run->weights + ((uint64_t)r * run->count + c) * run->bytes,
                                run->bytes);
}

/* Whether the heads of a run agree with the file's form and stay within `couplings` pairs. */
static bool is_run(const qs_qubo *q, const coupling_run *run, uint64_t couplings)
{
    if (run->block >= q->block_count || run->form > 1 || run->count == 0 || run->repeat == 0 ||
        (uint64_t)run->count * run->repeat > couplings ||
        (run->repeat == 1 ? run->stride != 0 : run->stride < run->count)) {
        return false;
    }
    if (run->bytes == 0
            ? run->weight == 0
            : run->weight != 0 || (run->bytes != 1 && run->bytes != 2 && run->bytes != 4)) {
        return false;
    }
    if (run->form == 1) {
        return run->first == 0 && run->second == 0 && run->repeat == 1;
    }
    uint64_t last = run->second + (run->repeat - 1ull) * run->stride + (run->count - 1ull);
    return run->first <= run->second && last < q->groups;
}

static bool are_pairs(const qs_qubo *q, const coupling_run *run)
{
    for (uint32_t c = 0; run->form == 1 && c < run->count; c++) {
        uint32_t first, second;
        run_pair(run, 0, c, &first, &second);
        if (first > second || second >= q->groups) {
            return false;
        }
    }
    return true;
}

static uint64_t weight_sum(const coupling_run *run)
{
    if (run->bytes == 0) {
        return absolute(run->weight) * run->count * run->repeat;
    }
    uint64_t sum = 0;
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            sum += absolute(run_weight(run, r, c));
        }
    }
    return sum;
}

static bool read_couplings(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "CPLS", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    if (chunk.length < 4) {
        return corrupt(o, chunk.offset, "length of CPLS");
    }
    if (q->couplings / COUPLINGS_PER_BYTE > q->size) {
        return corrupt(o, QS_HEADER_FIELDS + 8, "more couplings than its size allows");
    }
    q->coupling_run_count = qs_load_u32(chunk.payload);
    q->coupling_runs = chunk.payload + 4;
    uint64_t at = 4, couplings = 0;
    block_cursor cursor = {0};
    for (uint32_t i = 0; i < q->coupling_run_count; i++) {
        if (chunk.length - at < COUPLING_RUN) {
            return corrupt(o, chunk.offset + at, "length of CPLS");
        }
        coupling_run run = load_run(chunk.payload + at);
        if (run.block < cursor.block) {
            return corrupt(o, chunk.offset + at, "order of the blocks");
        }
        if (!is_run(q, &run, q->couplings - couplings) || run.size > chunk.length - at ||
            !are_pairs(q, &run)) {
            return corrupt(o, chunk.offset + at, "a run of couplings");
        }
        seek_block(q, &cursor, run.block);
        if (!grow(o, weight_sum(&run), cursor.whole.absolute)) {
            return corrupt(o, chunk.offset + at, "coefficients beyond 2^53");
        }
        couplings += (uint64_t)run.count * run.repeat;
        at += run.size;
    }
    return (at == chunk.length && couplings == q->couplings) ||
           corrupt(o, chunk.offset, "number of couplings");
}

static bool read_linear(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "LINR", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    if (chunk.length < 16 || !is_width(qs_load_u32(chunk.payload + 8)) ||
        qs_load_u32(chunk.payload + 12) != 0 ||
        (chunk.length - 16) % qs_load_u32(chunk.payload + 8) != 0 ||
        (chunk.length - 16) / qs_load_u32(chunk.payload + 8) != q->variables) {
        return corrupt(o, chunk.offset, "head or length of LINR");
    }
    q->linear_base = qs_load_i64(chunk.payload);
    q->linear_bytes = qs_load_u32(chunk.payload + 8);
    q->linear = chunk.payload + 16;
    for (uint32_t i = 0; i < q->variables; i++) {
        uint64_t u = qs_load_unsigned(q->linear + (size_t)i * q->linear_bytes, q->linear_bytes);
        /* With the base as a part of the sum and u beyond it no sum below can wrap. */
        if (u > 2 * (uint64_t)QS_ENERGY_MAX || absolute(q->linear_base) > (uint64_t)QS_ENERGY_MAX ||
            !grow(o, 1, absolute(q->linear_base + (int64_t)u))) {
            return corrupt(o, chunk.offset, "coefficients beyond 2^53");
        }
    }
    return true;
}

/* Walks the runs of penalties and of groups side by side, in pieces of one size and one pair each.
 */
typedef struct penalty_piece {
    size_t run, group_run;
    uint32_t in_run, in_group_run; /* groups passed of each */
    uint64_t count, size;
    uint64_t a, b;
} penalty_piece;

static size_t penalty_run_size(const qs_qubo *q)
{
    return 4 + 2 * (size_t)q->penalty_bytes;
}

static bool next_piece(const qs_qubo *q, penalty_piece *piece)
{
    if (piece->run == q->penalty_run_count || piece->group_run == q->group_run_count) {
        return false;
    }
    const uint8_t *run = q->penalty_runs + piece->run * penalty_run_size(q);
    const uint8_t *group_run = q->group_runs + piece->group_run * GROUP_RUN;
    uint32_t left = qs_load_u32(run) - piece->in_run,
             group_left = qs_load_u32(group_run) - piece->in_group_run;
    uint32_t count = left < group_left ? left : group_left;
    piece->count = count;
    piece->size = qs_load_u32(group_run + 4);
    piece->a = qs_load_unsigned(run + 4, q->penalty_bytes);
    piece->b = qs_load_unsigned(run + 4 + q->penalty_bytes, q->penalty_bytes);
    piece->run += count == left;
    piece->in_run = count == left ? 0 : piece->in_run + count;
    piece->group_run += count == group_left;
    piece->in_group_run = count == group_left ? 0 : piece->in_group_run + count;
    return true;
}

static bool read_penalty_runs(opening *o, const qs_chunk *chunk)
{
    qs_qubo *q = &o->qubo;
    size_t each = penalty_run_size(q);
    uint64_t groups = 0, largest = 0;
    for (size_t r = 0; r < q->penalty_run_count; r++) {
        const uint8_t *run = q->penalty_runs + r * each;
        uint64_t a = qs_load_unsigned(run + 4, q->penalty_bytes),
                 b = qs_load_unsigned(run + 4 + q->penalty_bytes, q->penalty_bytes);
        bool repeated = r > 0 && memcmp(run + 4, run + 4 - each, each - 4) == 0;
        groups += qs_load_u32(run);
        if (qs_load_u32(run) == 0 || repeated || groups > q->groups) {
            return corrupt(o, chunk->offset + 8 + r * each, "a run of penalties");
        }
        largest = a > largest ? a : largest;
        largest = b > largest ? b : largest;
    }
    return (groups == q->groups && qs_bytes_of(largest) == q->penalty_bytes) ||
           corrupt(o, chunk->offset, "number or width of the penalties");
}

static bool read_penalties(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "PNLT", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    if (chunk.length < 8 || !is_width(qs_load_u32(chunk.payload)) ||
        qs_load_u32(chunk.payload + 4) != 0) {
        return corrupt(o, chunk.offset, "head of PNLT");
    }
    q->penalty_bytes = qs_load_u32(chunk.payload);
    q->penalty_runs = chunk.payload + 8;
    q->penalty_run_count = (size_t)(chunk.length - 8) / penalty_run_size(q);
    if ((chunk.length - 8) % penalty_run_size(q) != 0) {
        return corrupt(o, chunk.offset, "length of PNLT");
    }
    if (!read_penalty_runs(o, &chunk)) {
        return false;
    }
    for (penalty_piece piece = {0}; next_piece(q, &piece);) {
        if (!grow(o, piece.a, piece.count * (1 + piece.size)) ||
            !grow(o, piece.b,
                  piece.count * piece.size / 2 * (piece.size - 1) +
                      (piece.count * piece.size % 2 != 0 ? (piece.size - 1) / 2 : 0))) {
            return corrupt(o, chunk.offset, "coefficients beyond 2^53");
        }
    }
    return true;
}

static bool read_offset(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "OFFS", &chunk)) {
        return false;
    }
    if (chunk.length != 8) {
        return corrupt(o, chunk.offset, "length of OFFS");
    }
    o->qubo.offset = qs_load_i64(chunk.payload);
    return grow(o, 1, absolute(o->qubo.offset)) ||
           corrupt(o, chunk.offset, "coefficients beyond 2^53");
}

qs_status qs_qubo_open(const void *bytes, size_t size, uint64_t memory_limit, qs_qubo *qubo,
                       qs_fault *fault)
{
    if ((!bytes && size > 0) || !qubo) {
        return QS_E_ARGUMENT;
    }
    opening o = {.reader = qs_reader_of(bytes, size, "GRPSBLKSCPLSLINRPNLTOFFS"),
                 .qubo = {.bytes = bytes, .size = size},
                 .memory_limit = memory_limit};
    bool good = qs_read_header(&o.reader, QS_MAGIC_QCF) && read_fields(&o) && read_groups(&o) &&
                read_blocks(&o) && read_couplings(&o) && read_linear(&o) && read_penalties(&o) &&
                read_offset(&o) && qs_labels_read(&o.reader, &o.qubo);
    if (good) {
        *qubo = o.qubo;
    } else if (fault) {
        *fault = o.reader.fault;
    }
    return o.reader.status;
}

int64_t qs_qubo_linear(const qs_qubo *qubo, uint32_t variable)
{
    size_t at = (size_t)variable * qubo->linear_bytes;
    return qubo->linear_base + (int64_t)qs_load_unsigned(qubo->linear + at, qubo->linear_bytes);
}

/* ---- Summary. ---- */

static void widen(int64_t *min, int64_t *max, int64_t value, bool first)
{
    *min = first || value < *min ? value : *min;
    *max = first || value > *max ? value : *max;
}

static void summarise_linear(const qs_qubo *q, qs_qubo_summary *s)
{
    uint32_t variable = 0;
    for (penalty_piece piece = {0}; next_piece(q, &piece);) {
        for (uint64_t i = 0; i < piece.count * piece.size; i++, variable++) {
            int64_t value = qs_qubo_linear(q, variable) - (int64_t)piece.a;
            widen(&s->linear_min, &s->linear_max, value, variable == 0);
        }
    }
}

static void add_terms(qs_qubo_summary *s, uint64_t terms, int64_t min, int64_t max)
{
    if (terms > 0) {
        widen(&s->quadratic_min, &s->quadratic_max, min, s->quadratic_terms == 0);
        widen(&s->quadratic_min, &s->quadratic_max, max, false);
        s->quadratic_terms += terms;
    }
}

static void summarise_penalties(const qs_qubo *q, qs_qubo_summary *s)
{
    bool first = true;
    for (penalty_piece piece = {0}; next_piece(q, &piece);) {
        if (piece.a == 0 && piece.b == 0) {
            continue;
        }
        int64_t a = (int64_t)piece.a, b = (int64_t)piece.b;
        widen(&s->penalty_min, &s->penalty_max, a, first);
        widen(&s->pair_penalty_min, &s->pair_penalty_max, b, first);
        first = false;
        s->offset += a * (int64_t)piece.count;
        add_terms(s, b == 0 ? 0 : piece.count * (piece.size * (piece.size - 1) / 2), b, b);
    }
}

static void summarise_run(const coupling_run *run, const block_cursor *cursor, qs_qubo_summary *s)
{
    for (uint32_t r = 0; r < run->repeat; r++) {
        for (uint32_t c = 0; c < run->count; c++) {
            uint32_t first, second;
            run_pair(run, r, c, &first, &second);
            const qs_block_facts *facts = first == second ? &cursor->upper : &cursor->whole;
            int64_t weight = run_weight(run, r, c), low = weight * facts->min,
                    high = weight * facts->max;
            add_terms(s, weight == 0 ? 0 : facts->terms, low < high ? low : high,
                      low < high ? high : low);
        }
    }
}

void qs_qubo_summarise(const qs_qubo *qubo, qs_qubo_summary *summary)
{
    qs_qubo_summary s = {.offset = qubo->offset};
    summarise_linear(qubo, &s);
    summarise_penalties(qubo, &s);
    const uint8_t *at = qubo->coupling_runs;
    block_cursor cursor = {0};
    for (uint32_t i = 0; i < qubo->coupling_run_count; i++) {
        coupling_run run = load_run(at);
        seek_block(qubo, &cursor, run.block);
        summarise_run(&run, &cursor, &s);
        at += run.size;
    }
    *summary = s;
}

/* ---- Index. ---- */

size_t qs_index_workspace(const qs_qubo *qubo)
{
    return qs_size(lay_out(qubo).end);
}

static void index_blocks(const qs_qubo *q, size_t *block_at_)
{
    size_t at = 4;
    for (uint32_t b = 0; b < q->block_count; b++) {
        block_at_[b] = at;
        at += (size_t)qs_block_size(q->blocks + at, UINT64_MAX);
    }
}

static void index_groups(const qs_qubo *q, uint32_t *start, uint32_t *penalty_run)
{
    uint32_t group = 0, variable = 0;
    for (size_t r = 0; r < q->group_run_count; r++) {
        uint32_t count = qs_load_u32(q->group_runs + r * GROUP_RUN),
                 size = qs_load_u32(q->group_runs + r * GROUP_RUN + 4);
        for (uint32_t i = 0; i < count; i++, variable += size) {
            start[group++] = variable;
        }
    }
    start[group] = variable;
    group = 0;
    for (size_t r = 0; r < q->penalty_run_count; r++) {
        uint32_t count = qs_load_u32(q->penalty_runs + r * penalty_run_size(q));
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
        coupling_run run = load_run(at);
        at += run.size;
        for (uint32_t r = 0; r < run.repeat; r++) {
            for (uint32_t c = 0; c < run.count; c++) {
                uint32_t g, h;
                run_pair(&run, r, c, &g, &h);
                if (near) {
                    int32_t weight = run_weight(&run, r, c);
                    near[near_start[g]] = (qs_neighbour){h, run.block, weight};
                    near[near_start[h]] =
                        g == h ? near[near_start[g]]
                               : (qs_neighbour){g, run.block | QS_TRANSPOSED, weight};
                }
                near_start[g]++;
                near_start[h] += g != h;
            }
        }
    }
}

/* Counts become first places and, as places are taken, the places behind the last: so starts are
 * shifted by one. */
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

/* The shapes of the blocks beside those of the groups that they couple. */
static bool shapes_agree(const qs_index *index)
{
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        for (uint32_t n = index->near_start[g]; n < index->near_start[g + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            const uint8_t *block =
                index->qubo->blocks + index->block_at[near->block & ~QS_TRANSPOSED];
            uint32_t other = index->start[near->group + 1] - index->start[near->group],
                     own = index->start[g + 1] - index->start[g];
            bool turned = (near->block & QS_TRANSPOSED) != 0;
            int64_t a = 0, b = 0;
            if (near->group == g) {
                qs_index_penalty(index, g, &a, &b);
            }
            if (qs_block_rows(block) != (turned ? other : own) ||
                qs_block_columns(block) != (turned ? own : other) || a != 0 || b != 0) {
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
    layout l = lay_out(qubo);
    if (workspace_size < l.end) {
        return QS_E_WORKSPACE;
    }
    char *base = workspace;
    size_t *blocks = (size_t *)(void *)(base + l.block_at);
    uint32_t *start = (uint32_t *)(void *)(base + l.start),
             *near_start = (uint32_t *)(void *)(base + l.near_start);
    uint32_t *penalty_run = (uint32_t *)(void *)(base + l.penalty_run);
    qs_neighbour *near = (qs_neighbour *)(void *)(base + l.near);
    index_blocks(qubo, blocks);
    index_groups(qubo, start, penalty_run);
    index_neighbours(qubo, near_start, near);
    qs_index built = {qubo, blocks, start, near_start, near, penalty_run};
    if (!shapes_agree(&built)) {
        return QS_E_CORRUPT;
    }
    *index = built;
    return QS_OK;
}

void qs_index_penalty(const qs_index *index, uint32_t group, int64_t *a, int64_t *b)
{
    const qs_qubo *q = index->qubo;
    const uint8_t *run = q->penalty_runs + index->penalty_run[group] * penalty_run_size(q);
    *a = (int64_t)qs_load_unsigned(run + 4, q->penalty_bytes);
    *b = (int64_t)qs_load_unsigned(run + 4 + q->penalty_bytes, q->penalty_bytes);
}

int32_t qs_index_block(const qs_index *index, uint32_t block, uint32_t row, uint32_t column)
{
    return qs_block_entry(index->qubo->blocks + index->block_at[block], row, column);
}
