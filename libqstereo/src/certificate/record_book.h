/* What a recorder of certificates keeps, and the parts of its work. */
#ifndef QS_RECORD_BOOK_H
#define QS_RECORD_BOOK_H

#include "../../include/qstereo/certificate.h"
#include "exact_order.h"
#include "search.h"
#include "stated_problem.h"

/* What a recorder keeps, in its workspace. Sites and labels are those of the file. */
typedef struct qs_record_book {
    qs_stated stated;
    uint32_t *cell; /* of each site: the model's site */
    uint32_t *place; /* of each site: the problem's, fixed ones and all */
    uint32_t *site; /* of each of the model's sites: the file's, or QS_NO_SITE */
    uint16_t *name; /* of each label: the model's label */
    uint32_t *slots; /* of each site: how many */
    uint16_t *first_slot, *second_slot; /* of each edge that is alive */
    size_t *share_at; /* of each site: where its shares begin */
    int64_t *shares; /* of each slot of a site but the last, of each of its labels */
    uint16_t *labelling; /* of each site, of the stage */
    uint8_t *claimed; /* of each label: it stays, says the solver */
    uint8_t *sets; /* of each label: it stays after the stage, or the round */
    uint32_t *stage, stage_count; /* the sites of the stage, or of the round, rising */
    uint8_t *due; /* of each site: its labels may be compared again */
    int64_t *costs; /* of labels of a site, for a moment */
    unsigned shift;
    bool pending; /* there is a split that has not been written, */
    bool told; /* and the solver has told which labels leave by it: none */
    unsigned unended; /* what the last stage has, if more of it may come: rounds
                         (QS_STAGE_LEAVES), QS_STAGE_PARTS or QS_STAGE_SEARCHES; else 0 */
    qs_exact exact;
    qs_exact_order order;
    uint64_t exact_cells; /* of all parts up to now */
    qs_search search;
    uint64_t search_work; /* that is still allowed: of all searches in the file, */
    uint64_t search_tries; /* and of all that have been tried */
} qs_record_book;

#define QS_NO_SITE UINT32_MAX

/* Returns true if the site is not settled. */
static inline bool qs_record_is_open(const qs_stated *s, uint32_t site)
{
    return !s->settled[site];
}

/* The label of the file that the model's label is, at a site that has it. */
static inline uint16_t qs_record_label(const qs_record_book *b, uint32_t site, uint32_t name)
{
    const uint16_t *names = b->name + b->stated.start[site];
    uint32_t a = 0;
    while (a + 1 < b->stated.count[site] && names[a] != name) {
        a++;
    }
    return (uint16_t)a;
}

/* Bytes of a label in the file. */
static inline unsigned qs_record_label_bytes(const qs_stated *s)
{
    return s->most_labels <= UINT8_MAX + 1u ? 1 : 2;
}

/* ---- The split (record_split.c), as a witness is told of it: see qs_witness. ---- */

void qs_record_split(qs_recorder *r, const qs_model *model, unsigned shift,
                     const uint16_t *labelling);
void qs_record_share(qs_recorder *r, const qs_model *model, uint32_t cell, uint32_t chain,
                     const void *share, unsigned bytes);

/* ---- Stages (record_stage.c). ---- */

/* Ends the stage. Returns false if there may be no more. */
bool qs_record_may_begin(qs_recorder *r);

/* The same where rounds or parts of a kind follow, unless the stage has them. */
bool qs_record_may_add(qs_recorder *r, unsigned kind);

/* Writes the stage of the split that is pending and, if labels leave, the sets: they leave then. */
void qs_record_stage(qs_recorder *r, bool leaves);

/* Writes a round of the book's sites, whose labels leave then. Rounds that come one after another
 * are a stage. */
void qs_record_round(qs_recorder *r);

/* ---- Labels that leave (record_leave.c). ---- */

/* Labels that are not claimed leave: by the split that is pending; and if it has been told what
 * leaves by that, or there is none, by Goldstein's criterion, in as many rounds as that takes. */
void qs_record_leave(qs_recorder *r);

/* Writes the part that has been solved, by tables or by search (`kind`). Parts of a kind that come
 * one after another are a stage. A split that waits is of the problem with the part, and there will
 * be another without it. */
void qs_record_part(qs_recorder *r, unsigned kind);

/* A stage of rounds or parts ends with one that has no sites. */
void qs_record_end_stage(qs_recorder *r);

#endif
