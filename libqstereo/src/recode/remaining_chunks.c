#include <string.h>

#include "../base/bytes.h"
#include "remaining.h"
#include "../qubo/sites.h"

void qs_put_labl_fields(qs_writer *writer, const qs_labels *l, bool masked)
{
    const qs_frame *f = &l->frame;
    uint32_t fields[16] = {l->encoding,
                           l->pairwise.smoothness,
                           l->pairwise.truncation,
                           l->labels,
                           l->scale,
                           l->penalty,
                           l->gap,
                           (uint32_t)l->weight,
                           l->width,
                           l->height,
                           f->picture_width,
                           f->picture_height,
                           f->x,
                           f->y,
                           f->first,
                           masked};
    for (int i = 0; i < 16; i++) {
        qs_put_u32(writer, fields[i]);
    }
}

static uint64_t mask_size(const qs_labels *l)
{
    return l->mask ? ((uint64_t)l->width * l->height + 7) / 8 : 0;
}

static void put_labl(qs_writer *writer, const void *context)
{
    const qs_labels *l = context;
    qs_put_labl_fields(writer, l, l->mask != NULL);
    if (l->mask) {
        qs_put(writer, l->mask, (size_t)mask_size(l));
    }
}

void qs_put_labl(qs_writer *writer, const qs_labels *labels)
{
    qs_put_chunk(writer, "labl", 64 + mask_size(labels), put_labl, labels);
}

/* ---- kept ---- */

/* Bytes of a site's label; 0 = every site is open and has all labels. */
static unsigned fixed_bytes(const qs_left *left)
{
    if (left->counts.whole && left->counts.open == left->counts.sites) {
        return 0;
    }
    return left->model->labels <= UINT8_MAX ? 1 : 2;
}

static void put_set(qs_writer *writer, const qs_left *left, uint32_t open)
{
    const uint16_t *label = left->label + left->start[open],
                   *end = left->label + left->start[open + 1];
    for (uint32_t at = 0; at < left->model->labels; at += 8) {
        unsigned byte = 0;
        for (; label < end && *label < at + 8; label++) {
            byte |= 1u << (*label - at);
        }
        qs_put_unsigned(writer, byte, 1);
    }
}

static void put_kept(qs_writer *writer, const void *context)
{
    const qs_left *left = context;
    unsigned bytes = fixed_bytes(left);
    qs_put_u32(writer, (uint32_t)left->counts.sites);
    qs_put_u32(writer, bytes);
    if (bytes == 0) {
        return;
    }
    for (uint32_t p = 0; p < left->model->sites; p++) {
        if (!qs_is_masked(left->model->mask, p)) {
            qs_put_unsigned(writer, left->number[p] == QS_NO_SITE ? left->fixed[p] : UINT16_MAX,
                            bytes);
        }
    }
    for (uint32_t open = 0; open < left->counts.open; open++) {
        put_set(writer, left, open);
    }
}

void qs_put_kept(qs_writer *writer, const qs_left *left)
{
    uint64_t bytes = fixed_bytes(left),
             sets = bytes > 0 ? left->counts.open * ((left->model->labels + 7) / 8) : 0;
    qs_put_chunk(writer, "kept", 8 + left->counts.sites * bytes + sets, put_kept, left);
}

/* ---- trnc ---- */

static unsigned excess_bytes(const qs_left *left)
{
    uint32_t largest = 0;
    for (uint64_t i = 0; i < left->counts.labels; i++) {
        largest = left->excess[i] > largest ? left->excess[i] : largest;
    }
    return qs_bytes_of(largest);
}

static void put_trnc(qs_writer *writer, const void *context)
{
    const qs_left *left = context;
    unsigned bytes = excess_bytes(left);
    qs_put_u32(writer, bytes);
    qs_put_u32(writer, 0);
    for (uint64_t i = 0; i < left->counts.labels; i++) {
        qs_put_unsigned(writer, left->excess[i], bytes);
    }
}

void qs_put_trnc(qs_writer *writer, const qs_left *left)
{
    qs_put_chunk(writer, "trnc", 8 + left->counts.labels * excess_bytes(left), put_trnc, left);
}
