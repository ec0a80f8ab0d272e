#include "../base/bytes.h"
#include "../files/container.h"
#include "certificate_layout.h"
#include "record_book.h"

typedef struct certificate_parts {
    const qs_recorder *recorder;
    const uint16_t *labelling;
    const uint8_t *stages;
    size_t stages_size;
} certificate_parts;

static void put_problem(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    uint8_t digest[QS_DIGEST_SIZE];
    qs_digest(parts->recorder->index->qubo->bytes, parts->recorder->index->qubo->size, digest);
    qs_put(writer, digest, sizeof digest);
}

static void put_best(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    const qs_record_book *b = parts->recorder->book;
    unsigned bytes = qs_record_label_bytes(&b->stated);
    qs_put_u32(writer, bytes);
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        qs_put_unsigned(writer, qs_record_label(b, p, parts->labelling[b->place[p]]), bytes);
    }
}

static void put_stages(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    qs_put(writer, parts->stages, parts->stages_size);
}

static void put_chunks(qs_writer *writer, const void *context)
{
    const certificate_parts *parts = context;
    const qs_stated *s = &parts->recorder->book->stated;
    qs_put_chunk(writer, "PROB", QS_DIGEST_SIZE, put_problem, context);
    qs_put_chunk(writer, "BEST", QS_BEST_HEAD + (uint64_t)s->sites * qs_record_label_bytes(s),
                 put_best, context);
    qs_put_chunk(writer, "STGS", parts->stages_size, put_stages, context);
}

qs_status qs_certificate_write(const qs_recorder *recorder, const uint16_t *labelling,
                               int64_t lower_bound, int64_t energy, const uint8_t *stages,
                               size_t stages_size, const qs_sink *sink, uint64_t *size)
{
    if (!recorder || !labelling || (!stages && stages_size > 0)) {
        return QS_E_ARGUMENT;
    }
    const qs_record_book *b = recorder->book;
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        uint32_t name = labelling[b->place[p]];
        if (b->name[b->stated.start[p] + qs_record_label(b, p, name)] != name) {
            return QS_E_ARGUMENT;
        }
    }
    uint8_t fields[QS_HEADER_OWN] = {0};
    qs_store_u32(fields, b->stated.sites);
    qs_store_u32(fields + 4, recorder->stages);
    qs_store_u64(fields + 8, (uint64_t)lower_bound);
    qs_store_u64(fields + 16, (uint64_t)energy);
    certificate_parts parts = {recorder, labelling, stages, stages_size};
    return qs_write_file(sink, QS_MAGIC_QPF, QS_QPF_CHUNK_COUNT, fields, put_chunks, &parts, size);
}
