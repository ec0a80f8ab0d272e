#include "container.h"

#include <string.h>

#include "../../include/qstereo/digest.h"
#include "../../include/qstereo/version.h"
#include "../base/bytes.h"

enum { MAGIC = 8, VERSION_AT = 8, CHUNKS_AT = 12, SIZE_AT = 16, CRC_AT = 60 };

static void flush(qs_writer *writer)
{
    size_t pending = writer->pending;
    writer->pending = 0;
    if (pending == 0 || writer->failed) {
        return;
    }
    writer->crc = writer->crc_of(writer->crc, writer->buffer, pending);
    writer->failed = !writer->sink->write(writer->sink->context, writer->buffer, pending);
}

void qs_put(qs_writer *writer, const void *bytes, size_t size)
{
    writer->size += size;
    if (!writer->sink || size == 0) {
        return;
    }
    if (size > sizeof writer->buffer - writer->pending) {
        flush(writer);
    }
    if (size <= sizeof writer->buffer) {
        memcpy(writer->buffer + writer->pending, bytes, size);
        writer->pending += size;
    } else if (!writer->failed) {
        writer->crc = writer->crc_of(writer->crc, bytes, size);
        writer->failed = !writer->sink->write(writer->sink->context, bytes, size);
    }
}

void qs_put_unsigned(qs_writer *writer, uint64_t value, unsigned bytes)
{
    uint8_t b[8];
    qs_store_u64(b, value);
    qs_put(writer, b, bytes);
}

void qs_put_u32(qs_writer *writer, uint32_t value)
{
    qs_put_unsigned(writer, value, 4);
}

void qs_put_u64(qs_writer *writer, uint64_t value)
{
    qs_put_unsigned(writer, value, 8);
}

static void chunk_begin(qs_writer *writer, const char *type, uint64_t length)
{
    flush(writer);
    writer->crc = 0;
    qs_put(writer, type, 4);
    qs_put_u32(writer, 0);
    qs_put_u64(writer, length);
}

static void chunk_end(qs_writer *writer)
{
    flush(writer);
    qs_put_u32(writer, writer->crc);
}

void qs_put_chunk(qs_writer *writer, const char *type, uint64_t length, qs_payload *payload,
                  const void *context)
{
    chunk_begin(writer, type, length);
    if (writer->sink) {
        payload(writer, context);
    } else {
        writer->size += length;
    }
    chunk_end(writer);
}

/* Apart, so that the header has left the stack when the chunks come. */
#if defined(__GNUC__)
__attribute__((noinline))
#endif
static void put_header(qs_writer *writer, const char *magic, uint32_t chunks, uint64_t file_size,
                       const uint8_t fields[QS_HEADER_OWN])
{
    uint8_t header[QS_HEADER_SIZE];
    memcpy(header, magic, MAGIC);
    qs_store_u32(header + VERSION_AT, QS_FORMAT_VERSION);
    qs_store_u32(header + CHUNKS_AT, chunks);
    qs_store_u64(header + SIZE_AT, file_size);
    memcpy(header + QS_HEADER_FIELDS, fields, QS_HEADER_OWN);
    qs_store_u32(header + CRC_AT, qs_crc32c_portable(0, header, CRC_AT));
    qs_put(writer, header, sizeof header);
}

qs_status qs_write_file(const qs_sink *sink, const char *magic, uint32_t chunks,
                        const uint8_t fields[QS_HEADER_OWN], qs_payload *put_chunks,
                        const void *context, uint64_t *size)
{
    qs_writer writer = {0}; /* one for both passes: small machines have small stacks */
    put_chunks(&writer, context);
    uint64_t file_size = QS_HEADER_SIZE + writer.size;
    writer = (qs_writer){.sink = sink, .crc_of = sink ? qs_crc32c_fastest() : NULL};
    put_header(&writer, magic, chunks, file_size, fields);
    put_chunks(&writer, context);
    flush(&writer);
    if (writer.failed) {
        return QS_E_IO;
    }
    if (size) {
        *size = writer.size;
    }
    return QS_OK;
}

bool qs_reject(qs_reader *reader, qs_status status, uint64_t offset, const char *what)
{
    if (reader->status == QS_OK) {
        reader->status = status;
        reader->fault = (qs_fault){offset, what};
    }
    return false;
}

qs_reader qs_reader_of(const void *bytes, size_t size, const char *types)
{
    return (qs_reader){.bytes = bytes, .size = size, .crc_of = qs_crc32c_fastest(), .types = types};
}

bool qs_read_header(qs_reader *reader, const char *magic)
{
    const uint8_t *header = reader->bytes;
    size_t known = reader->size < MAGIC ? (size_t)reader->size : MAGIC;
    if (known > 0 && memcmp(header, magic, known) != 0) {
        return qs_reject(reader, QS_E_FORMAT, 0, "magic");
    }
    if (reader->size < QS_HEADER_SIZE) {
        return qs_reject(reader, QS_E_TRUNCATED, reader->size, "header");
    }
    if (qs_load_u32(header + CRC_AT) != reader->crc_of(0, header, CRC_AT)) {
        return qs_reject(reader, QS_E_CORRUPT, CRC_AT, "CRC of the header");
    }
    if (qs_load_u32(header + VERSION_AT) != QS_FORMAT_VERSION) {
        return qs_reject(reader, QS_E_UNSUPPORTED, VERSION_AT, "version");
    }
    uint64_t size = qs_load_u64(header + SIZE_AT);
    if (reader->size < size) {
        return qs_reject(reader, QS_E_TRUNCATED, reader->size, "end of the file");
    }
    if (reader->size > size) {
        return qs_reject(reader, QS_E_CORRUPT, size, "bytes after the end");
    }
    reader->at = QS_HEADER_SIZE;
    reader->chunks = qs_load_u32(header + CHUNKS_AT);
    return true;
}

static bool next_chunk(qs_reader *reader, qs_chunk *chunk)
{
    uint64_t at = reader->at, left = reader->size - at;
    const uint8_t *frame = reader->bytes + at;
    if (reader->chunks == 0 || left < QS_CHUNK_FRAME) {
        return qs_reject(reader, QS_E_CORRUPT, at, "a chunk is missing");
    }
    chunk->length = qs_load_u64(frame + 8);
    if (chunk->length > left - QS_CHUNK_FRAME) {
        return qs_reject(reader, QS_E_CORRUPT, at + 8, "length of a chunk");
    }
    size_t covered = (size_t)(chunk->length + 16);
    if (qs_load_u32(frame + covered) != reader->crc_of(0, frame, covered)) {
        return qs_reject(reader, QS_E_CORRUPT, at + covered, "CRC of a chunk");
    }
    if (qs_load_u32(frame + 4) != 0) {
        return qs_reject(reader, QS_E_CORRUPT, at + 4, "reserved bytes of a chunk");
    }
    chunk->type = frame;
    chunk->payload = frame + 16;
    chunk->offset = at + 16;
    reader->at = at + covered + 4;
    reader->chunks--;
    return true;
}

static bool is_letters(const uint8_t *type)
{
    bool letters = true;
    for (int i = 0; i < 4; i++) {
        letters &= (type[i] | 0x20) >= 'a' && (type[i] | 0x20) <= 'z';
    }
    return letters;
}

/* Refuses a chunk that must not stand here: one of the listed types, or of a later version. Always
 * false. */
static bool misplaced(qs_reader *reader, const qs_chunk *chunk)
{
    uint64_t at = chunk->offset - 16;
    for (const char *type = reader->types; *type != '\0'; type += 4) {
        if (memcmp(chunk->type, type, 4) == 0) {
            return qs_reject(reader, QS_E_CORRUPT, at, "order of the chunks");
        }
    }
    if (!is_letters(chunk->type)) {
        return qs_reject(reader, QS_E_CORRUPT, at, "type of a chunk");
    }
    bool later = chunk->type[0] < 'a';
    return qs_reject(reader, later ? QS_E_UNSUPPORTED : QS_E_CORRUPT, at,
                     later ? "a chunk of a later version" : "order of the chunks");
}

bool qs_read_chunk(qs_reader *reader, const char *type, qs_chunk *chunk)
{
    return next_chunk(reader, chunk) &&
           (memcmp(chunk->type, type, 4) == 0 || misplaced(reader, chunk));
}

bool qs_check_reserved(qs_reader *reader, unsigned from)
{
    for (unsigned i = from; i < QS_HEADER_OWN; i++) {
        if (reader->bytes[QS_HEADER_FIELDS + i] != 0) {
            return qs_reject(reader, QS_E_CORRUPT, QS_HEADER_FIELDS + i,
                             "reserved bytes of the header");
        }
    }
    return true;
}

bool qs_read_problem_digest(qs_reader *reader, const uint8_t **digest)
{
    qs_chunk chunk;
    if (!qs_read_chunk(reader, "PROB", &chunk)) {
        return false;
    }
    if (chunk.length != QS_DIGEST_SIZE) {
        return qs_reject(reader, QS_E_CORRUPT, chunk.offset, "length of PROB");
    }
    *digest = chunk.payload;
    return true;
}

bool qs_read_side_chunk(qs_reader *reader, qs_chunk *chunk)
{
    if (reader->chunks == 0) {
        if (reader->at != reader->size) {
            qs_reject(reader, QS_E_CORRUPT, reader->at, "bytes after the last chunk");
        }
        return false;
    }
    if (!next_chunk(reader, chunk)) {
        return false;
    }
    bool is_side_chunk = is_letters(chunk->type) && chunk->type[0] >= 'a';
    return is_side_chunk || misplaced(reader, chunk);
}
