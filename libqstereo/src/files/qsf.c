#include "../../include/qstereo/samples.h"

#include <string.h>

#include "../../include/qstereo/limits.h"
#include "../base/bytes.h"
#include "container.h"

enum { RECORD_SIZE = 16, CHAIN_BREAKS_MAX = 1000000000 };

static size_t sample_bytes(uint32_t variables)
{
    return ((size_t)variables + 7) / 8;
}

/* Bytes of a UTF-8 character that begins with `first`; 0 = no character does. */
static size_t character_size(uint8_t first)
{
    if (first < 0x80) {
        return 1;
    }
    if (first < 0xc2 || first >= 0xf5) {
        return 0;
    }
    if (first < 0xe0) {
        return 2;
    }
    return first < 0xf0 ? 3 : 4;
}

/* Bytes of the UTF-8 character at `text`, of which `left` bytes are there; 0 = it is malformed (RFC
 * 3629). */
static size_t character(const uint8_t *text, size_t left)
{
    size_t size = character_size(text[0]);
    if (size > left) {
        return 0;
    }
    for (size_t i = 1; i < size; i++) {
        if ((text[i] & 0xc0) != 0x80) {
            return 0;
        }
    }
    if (size < 3) {
        return size;
    }
    bool too_long = (text[0] == 0xe0 && text[1] < 0xa0) || (text[0] == 0xf0 && text[1] < 0x90);
    bool surrogate = text[0] == 0xed && text[1] >= 0xa0,
         too_large = text[0] == 0xf4 && text[1] >= 0x90;
    return too_long || surrogate || too_large ? 0 : size;
}

static bool is_text(const uint8_t *text, size_t size)
{
    for (size_t at = 0, step; at < size; at += step) {
        step = character(text + at, size - at);
        if (step == 0) {
            return false;
        }
    }
    return true;
}

/* The control characters of ASCII, and those of Latin-1 (U+0080 to U+009F). */
static bool has_controls(const uint8_t *text, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        if (text[i] < 0x20 || text[i] == 0x7f || (text[i] == 0xc2 && text[i + 1] < 0xa0)) {
            return true;
        }
    }
    return false;
}

static bool is_solver(const uint8_t *name, size_t size)
{
    return size >= 1 && size <= 255 && is_text(name, size) && !has_controls(name, size);
}

/* Returns true if it looks like a JSON object from outside. What is inside is up to the solver. */
static bool is_object(const uint8_t *text, size_t size)
{
    return size >= 2 && text[0] == '{' && text[size - 1] == '}' && is_text(text, size);
}

static bool is_record(qs_record record)
{
    return record.occurrences >= 1 &&
           (record.chain_breaks <= CHAIN_BREAKS_MAX || record.chain_breaks == QS_NO_CHAINS);
}

static bool spare_bits_clear(const uint8_t *bits, uint32_t variables)
{
    return variables % 8 == 0 || bits[variables / 8] >> variables % 8 == 0;
}

static bool may_write(const qs_samples *samples)
{
    if (!samples || samples->variables > QS_VARIABLES_MAX || !samples->solver || !samples->info ||
        (samples->count > 0 && (!samples->records || !samples->bits)) ||
        !is_solver((const uint8_t *)samples->solver, samples->solver_size) ||
        !is_object((const uint8_t *)samples->info, samples->info_size)) {
        return false;
    }
    for (uint32_t i = 0; i < samples->count; i++) {
        const uint8_t *bits = samples->bits + i * sample_bytes(samples->variables);
        if (!is_record(samples->records[i]) || !spare_bits_clear(bits, samples->variables)) {
            return false;
        }
    }
    return true;
}

static void put_problem(qs_writer *writer, const void *context)
{
    qs_put(writer, ((const qs_samples *)context)->problem, QS_DIGEST_SIZE);
}

static void put_solver(qs_writer *writer, const void *context)
{
    const qs_samples *samples = context;
    qs_put(writer, samples->solver, samples->solver_size);
}

static void put_info(qs_writer *writer, const void *context)
{
    const qs_samples *samples = context;
    qs_put(writer, samples->info, samples->info_size);
}

static void put_records(qs_writer *writer, const void *context)
{
    const qs_samples *samples = context;
    for (uint32_t i = 0; i < samples->count; i++) {
        qs_put_u64(writer, (uint64_t)samples->records[i].energy);
        qs_put_u32(writer, samples->records[i].occurrences);
        qs_put_u32(writer, samples->records[i].chain_breaks);
    }
}

static void put_bits(qs_writer *writer, const void *context)
{
    const qs_samples *samples = context;
    qs_put(writer, samples->bits, samples->count * sample_bytes(samples->variables));
}

enum { CHUNKS = 5 };

static void put_chunks(qs_writer *writer, const void *context)
{
    const qs_samples *samples = context;
    uint64_t count = samples->count;
    qs_put_chunk(writer, "PROB", QS_DIGEST_SIZE, put_problem, samples);
    qs_put_chunk(writer, "SOLV", samples->solver_size, put_solver, samples);
    qs_put_chunk(writer, "INFO", samples->info_size, put_info, samples);
    qs_put_chunk(writer, "RECS", count * RECORD_SIZE, put_records, samples);
    qs_put_chunk(writer, "BITS", count * sample_bytes(samples->variables), put_bits, samples);
}

qs_status qs_samples_write(const qs_samples *samples, const qs_sink *sink, uint64_t *size)
{
    if (!may_write(samples)) {
        return QS_E_ARGUMENT;
    }
    uint8_t fields[QS_HEADER_OWN] = {0};
    qs_store_u32(fields, samples->variables);
    qs_store_u32(fields + 4, samples->count);
    return qs_write_file(sink, QS_MAGIC_QSF, CHUNKS, fields, put_chunks, samples, size);
}

static bool read_fields(qs_reader *reader, qs_samples_view *view)
{
    const uint8_t *fields = reader->bytes + QS_HEADER_FIELDS;
    view->variables = qs_load_u32(fields);
    view->count = qs_load_u32(fields + 4);
    if (view->variables > QS_VARIABLES_MAX) {
        return qs_reject(reader, QS_E_CORRUPT, QS_HEADER_FIELDS, "number of variables");
    }
    return qs_check_reserved(reader, 8);
}

static bool read_texts(qs_reader *reader, qs_samples_view *view)
{
    qs_chunk chunk;
    if (!qs_read_problem_digest(reader, &view->problem) || !qs_read_chunk(reader, "SOLV", &chunk)) {
        return false;
    }
    if (!is_solver(chunk.payload, (size_t)chunk.length)) {
        return qs_reject(reader, QS_E_CORRUPT, chunk.offset, "name of the solver");
    }
    view->solver = (const char *)chunk.payload;
    view->solver_size = (size_t)chunk.length;
    if (!qs_read_chunk(reader, "INFO", &chunk)) {
        return false;
    }
    if (!is_object(chunk.payload, (size_t)chunk.length)) {
        return qs_reject(reader, QS_E_CORRUPT, chunk.offset, "INFO is no JSON object");
    }
    view->info = (const char *)chunk.payload;
    view->info_size = (size_t)chunk.length;
    return true;
}

static bool read_samples(qs_reader *reader, qs_samples_view *view)
{
    qs_chunk chunk;
    if (!qs_read_chunk(reader, "RECS", &chunk)) {
        return false;
    }
    view->records = chunk.payload;
    if (chunk.length % RECORD_SIZE != 0 || chunk.length / RECORD_SIZE != view->count) {
        return qs_reject(reader, QS_E_CORRUPT, chunk.offset, "length of RECS");
    }
    for (uint32_t i = 0; i < view->count; i++) {
        if (!is_record(qs_samples_record(view, i))) {
            return qs_reject(reader, QS_E_CORRUPT, chunk.offset + (uint64_t)i * RECORD_SIZE,
                             "a record");
        }
    }
    if (!qs_read_chunk(reader, "BITS", &chunk)) {
        return false;
    }
    view->bits = chunk.payload;
    uint64_t each = sample_bytes(view->variables); /* of at most 2^28, times at most 2^32 */
    if (chunk.length != each * view->count) {
        return qs_reject(reader, QS_E_CORRUPT, chunk.offset, "length of BITS");
    }
    for (uint32_t i = 0; i < view->count; i++) {
        if (!spare_bits_clear(qs_samples_bits(view, i), view->variables)) {
            return qs_reject(reader, QS_E_CORRUPT, chunk.offset + (i + 1ull) * each - 1,
                             "spare bits of a sample");
        }
    }
    return true;
}

qs_status qs_samples_open(const void *bytes, size_t size, qs_samples_view *samples, qs_fault *fault)
{
    if ((!bytes && size > 0) || !samples) {
        return QS_E_ARGUMENT;
    }
    qs_reader reader = qs_reader_of(bytes, size, "PROBSOLVINFORECSBITS");
    qs_samples_view view = {0};
    if (qs_read_header(&reader, QS_MAGIC_QSF) && read_fields(&reader, &view) &&
        read_texts(&reader, &view) && read_samples(&reader, &view)) {
        for (qs_chunk chunk; qs_read_side_chunk(&reader, &chunk);) {
        }
    }
    if (reader.status == QS_OK) {
        *samples = view;
    } else if (fault) {
        *fault = reader.fault;
    }
    return reader.status;
}

qs_record qs_samples_record(const qs_samples_view *samples, uint32_t sample)
{
    const uint8_t *record = samples->records + (size_t)sample * RECORD_SIZE;
    return (qs_record){qs_load_i64(record), qs_load_u32(record + 8), qs_load_u32(record + 12)};
}

const uint8_t *qs_samples_bits(const qs_samples_view *samples, uint32_t sample)
{
    return samples->bits + sample * sample_bytes(samples->variables);
}
