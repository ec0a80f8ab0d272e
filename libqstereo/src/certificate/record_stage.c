#include "record_book.h"

#include <string.h>

#include "../base/bytes.h"
#include "../base/minmax.h"
#include "certificate_layout.h"

enum { PIECE = 256 };

typedef struct stage_writer {
    const qs_sink *sink;
    bool failed;
    size_t used;
    uint8_t piece[PIECE];
} stage_writer;

static void flush(stage_writer *w)
{
    w->failed = w->failed || (w->used > 0 && !w->sink->write(w->sink->context, w->piece, w->used));
    w->used = 0;
}

static void put(stage_writer *w, uint64_t value, unsigned bytes)
{
    uint8_t stored[8];
    if (w->used + bytes > PIECE) {
        flush(w);
    }
    qs_store_u64(stored, value);
    memcpy(w->piece + w->used, stored, bytes);
    w->used += bytes;
}

static unsigned slot_bytes(const qs_record_book *b)
{
    uint32_t most = 0;
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        most = qs_max_u32(most, b->slots[p]);
    }
    return most <= UINT8_MAX + 1u ? 1 : 2;
}

static size_t share_count(const qs_record_book *b, uint32_t site)
{
    bool open = qs_record_is_open(&b->stated, site);
    return open ? (size_t)(b->slots[site] - 1) * b->stated.count[site] : 0;
}

/* What there is of the shares. */
typedef struct share_range {
    int64_t low, high; /* 0 is between them */
    uint64_t slots;
} share_range;

static share_range range_of(const qs_record_book *b)
{
    share_range range = {0, 0, 0};
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        const int64_t *shares = b->shares + b->share_at[p];
        range.slots += qs_record_is_open(&b->stated, p) ? b->slots[p] : 0;
        for (size_t i = share_count(b, p); i-- > 0;) {
            range.low = qs_min_i64(range.low, shares[i]);
            range.high = qs_max_i64(range.high, shares[i]);
        }
    }
    return range;
}

/* Makes shares and scale so small that a check stays within its numbers: the lowest bits are lost,
 * which is a weaker split. Returns false if that is not enough. */
static bool make_small(qs_record_book *b, share_range *range)
{
    int64_t most = (int64_t)(QS_MOST_SHARES / qs_max_u64(range->slots, 1));
    unsigned lost = 0;
    while (range->low < -most || range->high > most ||
           b->stated.magnitude > QS_MOST_COSTS >> (b->shift - lost)) {
        if (lost++ == b->shift) {
            return false;
        }
        range->low /= 2;
        range->high /= 2;
    }
    b->shift -= lost;
    for (uint32_t p = 0; lost > 0 && p < b->stated.sites; p++) {
        for (size_t i = share_count(b, p); i-- > 0;) {
            b->shares[b->share_at[p] + i] /= (int64_t)1 << lost;
        }
    }
    return true;
}

static unsigned share_bytes(const share_range *range)
{
    unsigned bytes = 1;
    while (bytes < 8 && (range->low < -((int64_t)1 << (8 * bytes - 1)) ||
                         range->high >= (int64_t)1 << (8 * bytes - 1))) {
        bytes *= 2;
    }
    return bytes;
}

static void put_sites(stage_writer *w, const qs_record_book *b)
{
    put(w, b->stage_count, 4);
    for (uint32_t i = 0; i < b->stage_count; i++) {
        put(w, b->stage[i], 4);
    }
}

static void put_labels(stage_writer *w, const qs_record_book *b)
{
    unsigned bytes = qs_record_label_bytes(&b->stated);
    for (uint32_t i = 0; i < b->stage_count; i++) {
        put(w, b->labelling[b->stage[i]], bytes);
    }
}

/* Of all sites that are not settled. */
static void put_split(stage_writer *w, const qs_record_book *b, unsigned slot, unsigned share)
{
    const qs_stated *s = &b->stated;
    for (uint32_t i = 0; i < b->stage_count; i++) {
        uint32_t p = b->stage[i];
        for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
            uint32_t e = s->near[n];
            if (s->edges[e].alive && s->edges[e].first == p) {
                put(w, b->first_slot[e], slot);
                put(w, b->second_slot[e], slot);
            }
        }
    }
    for (uint32_t i = 0; i < b->stage_count; i++) {
        uint32_t p = b->stage[i];
        const int64_t *shares = b->shares + b->share_at[p];
        for (uint32_t n = 0; n < share_count(b, p); n++) {
            if (s->kept[qs_stated_at(s, p, n % s->count[p])]) {
                put(w, (uint64_t)shares[n], share);
            }
        }
    }
}

/* A bit for each label that is left, whether it stays. */
static void put_sets(stage_writer *w, const qs_record_book *b)
{
    const qs_stated *s = &b->stated;
    unsigned bits = 0, used = 0;
    for (uint32_t i = 0; i < b->stage_count; i++) {
        uint32_t p = b->stage[i];
        for (size_t at = s->start[p]; at < s->start[p + 1]; at++) {
            bits |= (unsigned)(s->kept[at] && b->sets[at]) << used;
            used += s->kept[at];
            if (used == 8) {
                put(w, bits, 1);
                bits = used = 0;
            }
        }
    }
    if (used > 0) {
        put(w, bits, 1);
    }
}

/* Takes over what stays. */
static void take_sets(qs_record_book *b)
{
    qs_stated *s = &b->stated;
    for (uint32_t i = 0; i < b->stage_count; i++) {
        size_t at = s->start[b->stage[i]];
        memcpy(s->kept + at, b->sets + at, s->count[b->stage[i]]);
    }
    for (uint32_t i = 0; i < b->stage_count; i++) {
        qs_stated_fold(s, b->stage[i]);
    }
}

/* What the labels of the sites are compared with, and which stay. */
static void put_leaving(stage_writer *w, qs_record_book *b)
{
    put_labels(w, b);
    put_sets(w, b);
    take_sets(b);
}

static void put_head(stage_writer *w, unsigned has, uint64_t scale, unsigned slot, unsigned share)
{
    put(w, has, 4);
    put(w, scale, 4);
    put(w, slot, 4);
    put(w, share, 4);
}

static void end_writing(qs_recorder *r, stage_writer *w)
{
    flush(w);
    r->status = w->failed ? QS_E_IO : r->status;
}

void qs_record_end_stage(qs_recorder *r)
{
    stage_writer w = {.sink = r->sink};
    if (r->book->unended) {
        put(&w, 0, 4);
        end_writing(r, &w);
    }
    r->book->unended = 0;
}

bool qs_record_may_begin(qs_recorder *r)
{
    qs_record_end_stage(r);
    if (r->stages == QS_STAGES_MOST) {
        r->status = QS_E_OVERFLOW;
    }
    return r->status == QS_OK;
}

bool qs_record_may_add(qs_recorder *r, unsigned kind)
{
    return r->book->unended == kind || qs_record_may_begin(r);
}

/* The sites of a split are all that are not settled. */
static void list_open(qs_record_book *b)
{
    b->stage_count = 0;
    for (uint32_t p = 0; p < b->stated.sites; p++) {
        b->stage[b->stage_count] = p;
        b->stage_count += qs_record_is_open(&b->stated, p);
    }
}

void qs_record_stage(qs_recorder *r, bool leaves)
{
    qs_record_book *b = r->book;
    if (!qs_record_may_begin(r)) {
        return;
    }
    stage_writer w = {.sink = r->sink};
    share_range range = range_of(b);
    if (!make_small(b, &range)) {
        r->status = QS_E_OVERFLOW;
        return;
    }
    list_open(b);
    unsigned slot = slot_bytes(b), share = share_bytes(&range);
    put_head(&w, QS_STAGE_SPLITS | (leaves ? QS_STAGE_LEAVES : 0u), (uint64_t)1 << b->shift, slot,
             share);
    put_split(&w, b, slot, share);
    if (leaves) {
        put_leaving(&w, b);
    }
    end_writing(r, &w);
    r->stages++;
    b->pending = false;
}

/* Begins a stage of rounds or parts, unless it has begun. */
static void add_to_stage(qs_recorder *r, stage_writer *w, unsigned kind)
{
    if (r->book->unended != kind) {
        put_head(w, kind, 0, 0, 0);
        r->stages++;
    }
    r->book->unended = kind;
}

void qs_record_round(qs_recorder *r)
{
    qs_record_book *b = r->book;
    stage_writer w = {.sink = r->sink};
    if (!qs_record_may_add(r, QS_STAGE_LEAVES)) {
        return;
    }
    add_to_stage(r, &w, QS_STAGE_LEAVES);
    put_sites(&w, b);
    put_leaving(&w, b);
    end_writing(r, &w);
}

void qs_record_part(qs_recorder *r, unsigned kind)
{
    qs_record_book *b = r->book;
    stage_writer w = {.sink = r->sink};
    add_to_stage(r, &w, kind);
    b->pending = false;
    put(&w, b->exact.count, 4);
    if (kind == QS_STAGE_PARTS) {
        put(&w, (uint64_t)b->exact.value, 8);
    }
    for (uint32_t i = 0; i < b->exact.count; i++) {
        put(&w, b->exact.sites[i], 4);
    }
    for (uint32_t i = 0; kind == QS_STAGE_SEARCHES && i < b->exact.count; i++) {
        put(&w, (uint64_t)b->search.least[i], 8);
    }
    end_writing(r, &w);
}
