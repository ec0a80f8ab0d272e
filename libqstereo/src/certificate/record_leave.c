#include "record_book.h"

#include <string.h>

#include "goldstein.h"

static bool has_more(const qs_record_book *b, uint32_t site)
{
    const qs_stated *s = &b->stated;
    bool more = false;
    for (size_t at = s->start[site]; at < s->start[site + 1]; at++) {
        more = more || (s->kept[at] && !b->claimed[at]);
    }
    return more;
}

static void leave_by_split(qs_recorder *r)
{
    qs_record_book *b = r->book;
    memcpy(b->sets, b->claimed, b->stated.start[b->stated.sites]);
    qs_record_stage(r, true);
}

/* Lists the sites that are due, and have labels that the criterion rules out now, with what they
 * are compared with. */
static void list_worse(qs_record_book *b, bool all)
{
    const qs_stated *s = &b->stated;
    b->stage_count = 0;
    for (uint32_t p = 0; p < s->sites; p++) {
        if (b->due[p] && has_more(b, p)) {
            uint32_t e = qs_goldstein_at(s, p, b->claimed, all, b->sets, b->costs);
            b->stage[b->stage_count] = p;
            b->stage_count += e != QS_NO_LABEL;
            b->labelling[p] = (uint16_t)e;
        }
        b->due[p] = 0;
    }
}

/* The sites of the round, and those around them, are due. */
static void call_again(const qs_record_book *b)
{
    const qs_stated *s = &b->stated;
    for (uint32_t i = 0; i < b->stage_count; i++) {
        uint32_t p = b->stage[i];
        b->due[p] = 1;
        for (uint32_t n = s->near_start[p]; n < s->near_start[p + 1]; n++) {
            b->due[qs_stated_other(&s->edges[s->near[n]], p)] = 1;
        }
    }
}

/* Rounds of the criterion, until it has no more to say. Returns true if there was one. */
static bool leave_in_rounds(qs_recorder *r, bool all)
{
    qs_record_book *b = r->book;
    bool any = false;
    memset(b->due, 1, b->stated.sites);
    list_worse(b, all);
    while (b->stage_count > 0 && r->status == QS_OK) {
        qs_record_round(r);
        call_again(b);
        list_worse(b, all);
        any = true;
    }
    return any;
}

void qs_record_leave(qs_recorder *r)
{
    if (r->book->pending && !r->book->told) {
        leave_by_split(r);
        return;
    }
    if (r->book->pending) { /* it is of the labels that are left now */
        qs_record_stage(r, false);
    }
    bool again = true;
    while (again) { /* mostly the cheapest labels are all that it takes */
        (void)leave_in_rounds(r, false);
        again = leave_in_rounds(r, true);
    }
}
