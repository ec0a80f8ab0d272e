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
    QS_HEADER_OWN = 36, /* and their bytes */
    QS_CHUNK_FRAME = 20 /* bytes of a chunk beside its payload */
};

#define QS_MAGIC_QCF "\x89QCF\r\n\x1a\n"
#define QS_MAGIC_QSF "\x89QSF\r\n\x1a\n"

/* ---- Writing. ---- */

#ifdef QS_SMALL /* for small machines: the same bytes with less memory, in more calls of the sink */
enum { QS_WRITER_BUFFER = 8 };
#else
enum { QS_WRITER_BUFFER = 256 };
#endif

/* Gathers small pieces, so that the sink is called rarely. Zero = it has no sink and only
 * counts. */
typedef struct qs_writer {
    const qs_sink *sink;
    qs_crc *crc_of;
    uint64_t size; /* bytes put so far */
    uint32_t crc; /* of the bytes flushed since qs_chunk_begin */
    bool failed; /* the sink refused bytes; it is called no more */
    size_t pending; /* bytes in the buffer */
    uint8_t buffer[QS_WRITER_BUFFER];
} qs_writer;

void qs_put(qs_writer *writer, const void *bytes, size_t size);
void qs_put_u32(qs_writer *writer, uint32_t value);
void qs_put_u64(qs_writer *writer, uint64_t value);
void qs_put_unsigned(qs_writer *writer, uint64_t value, unsigned bytes);

/* Puts a part of a file. */
typedef void qs_payload(qs_writer *writer, const void *context);

/* Puts a whole chunk. `payload` puts its `length` bytes; a writer that only counts does not call
 * it. */
void qs_put_chunk(qs_writer *writer, const char *type, uint64_t length, qs_payload *payload,
                  const void *context);

/* Writes a whole file: counts its bytes, then puts the header and the chunks.
 *
 * sink        NULL = count only
 * chunks      their number
 * fields      the header's own fields of the format
 * put_chunks  puts all of them, given `context`; called twice
 * size        out, may be NULL
 * Returns QS_OK or QS_E_IO. */
qs_status qs_write_file(const qs_sink *sink, const char *magic, uint32_t chunks,
                        const uint8_t fields[QS_HEADER_OWN], qs_payload *put_chunks,
                        const void *context, uint64_t *size);

/* ---- Reading. ---- */

/* A cursor over a file in memory. It keeps the first fault. Its functions return false at a
 * fault. */
typedef struct qs_reader {
    const uint8_t *bytes;
    uint64_t size, at;
    qs_crc *crc_of;
    const char *types; /* of the chunks that every file has, four letters each, in their order */
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

/* Checks that the header's own bytes from number `from` of its fields on are 0. */
bool qs_check_reserved(qs_reader *reader, unsigned from);

/* The next chunk, PROB: the digest of a problem, QS_DIGEST_SIZE bytes. */
bool qs_read_problem_digest(qs_reader *reader, const uint8_t **digest);

/* The next side chunk. False also where there is none: then the status is QS_OK. */
bool qs_read_side_chunk(qs_reader *reader, qs_chunk *chunk);

/* Notes the first fault; always false. */
bool qs_reject(qs_reader *reader, qs_status status, uint64_t offset, const char *what);

#endif
