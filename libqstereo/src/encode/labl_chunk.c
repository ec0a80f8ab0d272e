#include "labl_chunk.h"

#include "../base/minmax.h"
#include "../files/qcf_layout.h"

typedef struct payload {
    const qs_labels *labels;
    const uint8_t *cells;
} payload;

static uint64_t cell_count(const qs_labels *l)
{
    return (uint64_t)l->width * l->height;
}

static bool is_masked(const payload *p)
{
    return p->cells || p->labels->mask;
}

static void put_fields(qs_writer *writer, const payload *p)
{
    const qs_labels *l = p->labels;
    const qs_frame *f = &l->frame;
    qs_put_u32(writer, l->encoding);
    qs_put_u32(writer, l->pairwise.smoothness);
    qs_put_u32(writer, l->pairwise.truncation);
    qs_put_u32(writer, l->labels);
    qs_put_u32(writer, l->scale);
    qs_put_u32(writer, l->penalty);
    qs_put_u32(writer, l->gap);
    qs_put_u32(writer, (uint32_t)l->weight);
    qs_put_u32(writer, l->width);
    qs_put_u32(writer, l->height);
    qs_put_u32(writer, f->picture_width);
    qs_put_u32(writer, f->picture_height);
    qs_put_u32(writer, f->x);
    qs_put_u32(writer, f->y);
    qs_put_u32(writer, (uint32_t)f->first);
    qs_put_u32(writer, is_masked(p));
}

static void put_cells(qs_writer *writer, const uint8_t *cells, uint64_t count)
{
    for (uint64_t at = 0; at < count; at += 8) {
        uint64_t end = qs_min_u64(at + 8, count);
        unsigned byte = 0;
        for (uint64_t i = at; i < end; i++) {
            byte |= (unsigned)(cells[i] != 0) << (i - at);
        }
        qs_put_unsigned(writer, byte, 1);
    }
}

static void put_payload(qs_writer *writer, const void *context)
{
    const payload *p = context;
    put_fields(writer, p);
    if (p->cells) {
        put_cells(writer, p->cells, cell_count(p->labels));
    } else if (p->labels->mask) {
        qs_put(writer, p->labels->mask, (size_t)qs_bit_bytes(cell_count(p->labels)));
    }
}

static void put_meaning(qs_writer *writer, const void *context)
{
    const qs_meaning *meaning = context;
    qs_put_u32(writer, meaning->kind);
    qs_put_u32(writer, meaning->step);
    qs_put_u32(writer, meaning->columns);
    qs_put_u32(writer, meaning->unit);
    qs_put_u32(writer, (uint32_t)meaning->x);
    qs_put_u32(writer, (uint32_t)meaning->y);
}

uint32_t qs_labl_chunks(const qs_meaning *meaning)
{
    return meaning->kind == QS_MEANS_DISPARITY && meaning->unit == 0 ? 1 : 2;
}

void qs_put_labl(qs_writer *writer, const qs_labels *labels, const uint8_t *cells)
{
    payload p = {labels, cells};
    uint64_t mask = is_masked(&p) ? qs_bit_bytes(cell_count(labels)) : 0;
    qs_put_chunk(writer, "labl", QS_LABL_HEAD + mask, put_payload, &p);
    if (qs_labl_chunks(&labels->meaning) > 1) {
        qs_put_chunk(writer, "mean", QS_MEAN_SIZE, put_meaning, &labels->meaning);
    }
}
