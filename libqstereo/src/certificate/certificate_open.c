#include "../../include/qstereo/certificate.h"

#include "../base/bytes.h"
#include "../files/container.h"
#include "certificate_layout.h"

static bool read_fields(qs_reader *reader, qs_certificate *view)
{
    const uint8_t *fields = reader->bytes + QS_HEADER_FIELDS;
    view->sites = qs_load_u32(fields);
    view->stages = qs_load_u32(fields + 4);
    view->lower_bound = qs_load_i64(fields + 8);
    view->energy = qs_load_i64(fields + 16);
    if (view->stages > QS_STAGES_MOST) {
        return qs_reject(reader, QS_E_CORRUPT, QS_HEADER_FIELDS + 4, "number of stages");
    }
    return qs_check_reserved(reader, QS_QPF_FIELDS);
}

static bool read_chunks(qs_reader *reader, qs_certificate *view)
{
    qs_chunk chunk;
    if (!qs_read_problem_digest(reader, &view->problem) || !qs_read_chunk(reader, "BEST", &chunk)) {
        return false;
    }
    view->label_bytes = chunk.length >= QS_BEST_HEAD ? qs_load_u32(chunk.payload) : 0;
    view->labelling = chunk.payload + QS_BEST_HEAD;
    if ((view->label_bytes != 1 && view->label_bytes != 2) ||
        chunk.length != QS_BEST_HEAD + (uint64_t)view->sites * view->label_bytes) {
        return qs_reject(reader, QS_E_CORRUPT, chunk.offset, "length or width of BEST");
    }
    if (!qs_read_chunk(reader, "STGS", &chunk)) {
        return false;
    }
    view->stage_bytes = chunk.payload;
    view->stage_size = chunk.length;
    view->stage_offset = chunk.offset;
    return true;
}

qs_status qs_certificate_open(const void *bytes, size_t size, qs_certificate *certificate,
                              qs_fault *fault)
{
    if ((!bytes && size > 0) || !certificate) {
        return QS_E_ARGUMENT;
    }
    qs_reader reader = qs_reader_of(bytes, size, QS_QPF_CHUNKS);
    qs_certificate view = {0};
    if (qs_read_header(&reader, QS_MAGIC_QPF) && read_fields(&reader, &view) &&
        read_chunks(&reader, &view)) {
        for (qs_chunk chunk; qs_read_side_chunk(&reader, &chunk);) {
        }
    }
    if (reader.status == QS_OK) {
        *certificate = view;
    } else if (fault) {
        *fault = reader.fault;
    }
    return reader.status;
}
