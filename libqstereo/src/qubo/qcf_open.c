#include "../../include/qstereo/qubo.h"

#include <string.h>

#include "../base/minmax.h"
#include "../base/saturate.h"
#include "../files/container.h"
#include "qcf_labels.h"
#include "qcf_runs.h"

enum { COUPLINGS_PER_BYTE = 16 /* of the file: so a small file cannot ask for long work */ };

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

static bool is_width(uint32_t bytes)
{
    return bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8;
}

static bool within_memory(opening *o)
{
    return qs_index_workspace(&o->qubo) <= qs_min_u64(o->memory_limit, SIZE_MAX - 1) ||
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
    if (!qs_check_reserved(&o->reader, 16)) {
        return false;
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
    q->group_run_count = (size_t)(chunk.length / QS_GROUP_RUN);
    for (size_t r = 0; r < q->group_run_count; r++) {
        qs_group_run run = qs_group_run_at(q, r);
        groups += run.count;
        variables += (uint64_t)run.count * run.size;
        if (run.count == 0 || run.size == 0 || run.size == before || groups > q->groups ||
            variables > q->variables) {
            return corrupt(o, chunk.offset + r * QS_GROUP_RUN, "a run of groups");
        }
        before = run.size;
    }
    return (chunk.length % QS_GROUP_RUN == 0 && groups == q->groups && variables == q->variables) ||
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
    uint64_t at = QS_BLOCKS_HEAD;
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

static bool is_weight_width(uint32_t bytes)
{
    return bytes == 1 || bytes == 2 || bytes == 4;
}

/* Returns true if the head of a run is well-formed and it has at most `couplings` pairs. */
static bool is_run(const qs_qubo *q, const qs_run_view *run, uint64_t couplings)
{
    const qs_run *head = &run->head;
    bool same = head->weight_bytes == 0;
    if (head->block >= q->block_count || run->form > 1 || head->count == 0 || head->repeat == 0 ||
        qs_run_pairs(head) > couplings ||
        (head->repeat == 1 ? head->stride != 0 : head->stride < head->count)) {
        return false;
    }
    if ((head->weight == 0) == same || !(same || is_weight_width(head->weight_bytes))) {
        return false;
    }
    if (head->is_list) {
        return head->first == 0 && head->second == 0 && head->repeat == 1;
    }
    uint64_t last = head->second + (head->repeat - 1ull) * head->stride + (head->count - 1ull);
    return head->first <= head->second && last < q->groups;
}

/* Returns true if each pair of a list stands for two groups in their order. */
static bool are_pairs(const qs_qubo *q, const qs_run_view *run)
{
    uint32_t listed = run->head.is_list ? run->head.count : 0;
    for (uint32_t c = 0; c < listed; c++) {
        uint32_t first, second;
        qs_run_pair(run, 0, c, &first, &second);
        if (first > second || second >= q->groups) {
            return false;
        }
    }
    return true;
}

/* A run at byte `at` of the chunk. */
static bool read_run(opening *o, const qs_chunk *chunk, uint64_t at, uint64_t couplings,
                     qs_block_cursor *cursor)
{
    qs_qubo *q = &o->qubo;
    if (chunk->length - at < QS_RUN_HEAD) {
        return corrupt(o, chunk->offset + at, "length of CPLS");
    }
    qs_run_view run = qs_run_at(chunk->payload + at);
    if (run.head.block < cursor->block) {
        return corrupt(o, chunk->offset + at, "order of the blocks");
    }
    if (!is_run(q, &run, q->couplings - couplings) || run.size > chunk->length - at ||
        !are_pairs(q, &run)) {
        return corrupt(o, chunk->offset + at, "a run of couplings");
    }
    qs_block_seek(q, cursor, run.head.block);
    return grow(o, qs_run_weight_sum(&run), cursor->whole.absolute) ||
           corrupt(o, chunk->offset + at, "coefficients beyond 2^53");
}

static bool read_couplings(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "CPLS", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    if (chunk.length < QS_RUNS_HEAD) {
        return corrupt(o, chunk.offset, "length of CPLS");
    }
    if (q->couplings / COUPLINGS_PER_BYTE > q->size) {
        return corrupt(o, QS_HEADER_FIELDS + 8, "more couplings than its size allows");
    }
    q->coupling_run_count = qs_load_u32(chunk.payload);
    q->coupling_runs = chunk.payload + QS_RUNS_HEAD;
    uint64_t at = QS_RUNS_HEAD, couplings = 0;
    qs_block_cursor cursor = {0};
    for (uint32_t i = 0; i < q->coupling_run_count; i++) {
        if (!read_run(o, &chunk, at, couplings, &cursor)) {
            return false;
        }
        qs_run_view run = qs_run_at(chunk.payload + at);
        couplings += qs_run_pairs(&run.head);
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
    if (chunk.length < QS_LINEAR_HEAD) {
        return corrupt(o, chunk.offset, "head or length of LINR");
    }
    uint64_t bytes = qs_load_u32(chunk.payload + 8), length = chunk.length - QS_LINEAR_HEAD;
    if (!is_width((uint32_t)bytes) || qs_load_u32(chunk.payload + 12) != 0 ||
        length != q->variables * bytes) {
        return corrupt(o, chunk.offset, "head or length of LINR");
    }
    q->linear_base = qs_load_i64(chunk.payload);
    q->linear_bytes = (unsigned)bytes;
    q->linear = chunk.payload + QS_LINEAR_HEAD;
    for (uint32_t i = 0; i < q->variables; i++) {
        uint64_t u = qs_load_unsigned(q->linear + (size_t)i * q->linear_bytes, q->linear_bytes);
        /* With the base as a part of the sum and u beyond it no sum below can wrap. */
        if (u > 2 * (uint64_t)QS_ENERGY_MAX ||
            qs_absolute(q->linear_base) > (uint64_t)QS_ENERGY_MAX ||
            !grow(o, 1, qs_absolute(q->linear_base + (int64_t)u))) {
            return corrupt(o, chunk.offset, "coefficients beyond 2^53");
        }
    }
    return true;
}

static bool read_penalty_runs(opening *o, const qs_chunk *chunk)
{
    qs_qubo *q = &o->qubo;
    uint64_t groups = 0, largest = 0;
    qs_penalty_run before = {0};
    for (size_t r = 0; r < q->penalty_run_count; r++) {
        qs_penalty_run run = qs_penalty_run_at(q, r);
        bool repeated = r > 0 && run.a == before.a && run.b == before.b;
        groups += run.count;
        if (run.count == 0 || repeated || groups > q->groups) {
            uint64_t at = QS_PENALTIES_HEAD + r * qs_penalty_run_size(q->penalty_bytes);
            return corrupt(o, chunk->offset + at, "a run of penalties");
        }
        largest = qs_max_u64(largest, qs_max_u64(run.a, run.b));
        before = run;
    }
    return (groups == q->groups && qs_bytes_of(largest) == q->penalty_bytes) ||
           corrupt(o, chunk->offset, "number or width of the penalties");
}

/* b S (S - 1) / 2 of `count` groups with S = `size`: count x size / 2 x (size - 1), in an order in
 * which nothing overflows. */
static bool grow_pairs(opening *o, const qs_penalty_piece *piece)
{
    uint64_t variables = piece->count * piece->size, others = piece->size - 1;
    bool odd = variables % 2 != 0; /* then `others` is even */
    return grow(o, piece->b, variables / 2 * others + (odd ? others / 2 : 0));
}

static bool read_penalties(opening *o)
{
    qs_chunk chunk;
    if (!qs_read_chunk(&o->reader, "PNLT", &chunk)) {
        return false;
    }
    qs_qubo *q = &o->qubo;
    if (chunk.length < QS_PENALTIES_HEAD || !is_width(qs_load_u32(chunk.payload)) ||
        qs_load_u32(chunk.payload + 4) != 0) {
        return corrupt(o, chunk.offset, "head of PNLT");
    }
    q->penalty_bytes = qs_load_u32(chunk.payload);
    q->penalty_runs = chunk.payload + QS_PENALTIES_HEAD;
    uint64_t length = chunk.length - QS_PENALTIES_HEAD,
             each = qs_penalty_run_size(q->penalty_bytes);
    q->penalty_run_count = (size_t)(length / each);
    if (length % each != 0) {
        return corrupt(o, chunk.offset, "length of PNLT");
    }
    if (!read_penalty_runs(o, &chunk)) {
        return false;
    }
    for (qs_penalty_piece piece = {0}; qs_penalty_piece_next(q, &piece);) {
        if (!grow(o, piece.a, piece.count * (1 + piece.size)) || !grow_pairs(o, &piece)) {
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
    return grow(o, 1, qs_absolute(o->qubo.offset)) ||
           corrupt(o, chunk.offset, "coefficients beyond 2^53");
}

qs_status qs_qubo_open(const void *bytes, size_t size, uint64_t memory_limit, qs_qubo *qubo,
                       qs_fault *fault)
{
    if ((!bytes && size > 0) || !qubo) {
        return QS_E_ARGUMENT;
    }
    opening o = {.reader = qs_reader_of(bytes, size, QS_QCF_CHUNKS),
                 .qubo = {.bytes = bytes, .size = size},
                 .memory_limit = memory_limit};
    bool good = qs_read_header(&o.reader, QS_MAGIC_QCF) && read_fields(&o) && read_groups(&o) &&
                read_blocks(&o) && read_couplings(&o) && read_linear(&o) && read_penalties(&o) &&
                read_offset(&o) && qs_labels_read(&o.reader, &o.qubo);
    if (good || o.reader.status == QS_E_LIMIT) {
        *qubo = o.qubo;
    }
    if (!good && fault) {
        *fault = o.reader.fault;
    }
    return o.reader.status;
}
