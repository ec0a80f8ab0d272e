/* The sites of a .qcf, one after another, with the labels and the variables of each
 * (docs/FORMAT.md, side chunks labl and kept). */
#ifndef QS_SITES_H
#define QS_SITES_H

#include "../../include/qstereo/qubo.h"
#include "../base/bits.h"
#include "../base/bytes.h"
#include "../files/qcf_layout.h"

/* Returns true if a cell of a grid is masked. `mask` as in qs_labels; NULL = none is. */
static inline bool qs_is_masked(const uint8_t *mask, uint32_t cell)
{
    return mask && !qs_bit(mask, cell);
}

/* What the chunk kept says of a site: the label that it is fixed at, or qs_undecided_mark. */
static inline uint32_t qs_fixed_at(const qs_labels *labels, uint32_t site)
{
    return (uint32_t)qs_load_unsigned(labels->fixed + (size_t)site * labels->fixed_bytes,
                                      labels->fixed_bytes);
}

static inline uint32_t qs_undecided_mark(const qs_labels *labels)
{
    return labels->fixed_bytes == 1 ? UINT8_MAX : UINT16_MAX;
}

static inline qs_site_code qs_code_of(const qs_labels *labels)
{
    return qs_encoding_facts_of(labels->encoding)->code;
}

/* The variables behind those of the sites. Where no site is undecided there are none. */
static inline qs_auxiliaries qs_auxiliaries_of(const qs_labels *labels)
{
    return labels->undecided > 0 ? qs_encoding_facts_of(labels->encoding)->auxiliaries
                                 : QS_NO_AUXILIARIES;
}

/* A site. It is a cursor over all sites, too: with `labels` alone set it stands before the
 * first. */
typedef struct qs_site {
    const qs_labels *labels;
    uint32_t next; /* number of the site after this one */
    uint32_t next_number; /* of the undecided site after it */
    uint64_t next_variable;
    /* This site: */
    uint32_t number; /* among the undecided sites, if it is one */
    uint32_t count; /* labels left. A site with 1 is fixed, but for problems of one label without
                       the chunk kept */
    uint32_t fixed; /* the label of a fixed site */
    uint64_t variable; /* its first one */
    bool is_undecided;
    const uint8_t *set; /* of an undecided site; NULL = all labels */
} qs_site;

/* The next site; false after the last. */
bool qs_site_next(qs_site *site);

/* An undecided site by its number among them, with its set alone: enough for the functions
 * below. */
static inline qs_site qs_undecided_site(const qs_labels *labels, uint32_t number)
{
    const uint8_t *set = labels->fixed_bytes > 0
                             ? labels->sets + number * (size_t)qs_bit_bytes(labels->labels)
                             : NULL;
    return (qs_site){.labels = labels, .number = number, .is_undecided = true, .set = set};
}

/* Returns true if a label is left to the site. */
static inline bool qs_site_has(const qs_site *site, uint32_t label)
{
    if (!site->is_undecided) {
        return label == site->fixed;
    }
    return !site->set || qs_bit(site->set, label);
}

/* The first label left to the site from `label` on; the number of all labels = none. */
static inline uint32_t qs_site_label_from(const qs_site *site, uint32_t label)
{
    while (label < site->labels->labels && !qs_site_has(site, label)) {
        label++;
    }
    return label;
}

#endif
