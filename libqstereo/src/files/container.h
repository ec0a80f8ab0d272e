/* The container of both files: a header of 64 bytes and chunks (docs/FORMAT.md, section 1). */
#ifndef QS_CONTAINER_H
#define QS_CONTAINER_H

#include <stdbool.h>

#include "../../include/qstereo/status.h"
#include "../../include/qstereo/stream.h"
#include "crc32c.h"

enum {
    QS_HEADER_SIZE = 64,
    QS_HEADER_FIELDS = 24, /* where a format's own fields begin */
    QS_CHUNK_FRAME = 20 /* bytes of a chunk beside its payload */
};

#define QS_MAGIC_QCF "\x89QCF\r\n\x1a\n"
#define QS_MAGIC_QSF "\x89QSF\r\n\x1a\n"

#ifdef QS_SMALL /* for small machines: the same bytes with less memory, in more calls of the sink */
enum { QS_WRITER_BUFFER = 16 };
#else
enum { QS_WRITER_BUFFER = 256 };
#endif

/* Writing. Zero counts only. Small pieces are gathered, so that a sink sees few calls. */
typedef struct qs_writer {
    const qs_sink *sink;
    qs_crc *crc_of;
    uint64_t size; /* bytes put so far */
    uint32_t crc; /* of the bytes flushed since qs_chunk_begin */
    bool failed;
    size_t pending;
    uint8_t buffer[QS_WRITER_BUFFER];
} qs_writer;

qs_writer qs_writer_to(const qs_sink *sink); /* NULL: counts only */
void qs_put(qs_writer *writer, const void *bytes, size_t size);
void qs_put_u32(qs_writer *writer, uint32_t value);
void qs_put_u64(qs_writer *writer, uint64_t value);
void qs_put_unsigned(qs_writer *writer, uint64_t value, unsigned bytes);

void qs_put_header(qs_writer *writer, const char *magic, uint32_t chunks, uint64_t file_size,
                   const uint8_t fields[36]);
void qs_chunk_begin(qs_writer *writer, const char *type, uint64_t length);
void qs_chunk_end(qs_writer *writer);
void qs_flush(qs_writer *writer);

/* A whole chunk, whose payload of `length` bytes is put by a function. When only counting, it is
 * not called. */
typedef void qs_payload(qs_writer *writer, const void *context);
void qs_put_chunk(qs_writer *writer, const char *type, uint64_t length, qs_payload *payload,
                  const void *context);

/* Reading: a cursor over a file in memory that keeps the first fault. */
typedef struct qs_reader {
    const uint8_t *bytes;
    uint64_t size, at;
    qs_crc *crc_of;
    const char *types; /* of the chunks that must be there, one after another */
    uint32_t chunks; /* still to come */
    qs_status status;
    qs_fault fault;
} qs_reader;

typedef struct qs_chunk {
    const uint8_t *type, *payload;
    uint64_t length;
    uint64_t offset; /* of the payload in the file */
} qs_chunk;

qs_reader qs_reader_of(const void *bytes, size_t size, const char *types);

/* Checks the header. */
bool qs_read_header(qs_reader *reader, const char *magic);

/* The next chunk, which must be of `type`. */
bool qs_read_chunk(qs_reader *reader, const char *type, qs_chunk *chunk);

/* The next side chunk, if there is one. */
bool qs_read_side_chunk(qs_reader *reader, qs_chunk *chunk);

/* Notes the first fault; always false. */
bool qs_reject(qs_reader *reader, qs_status status, uint64_t offset, const char *what);

#endif
