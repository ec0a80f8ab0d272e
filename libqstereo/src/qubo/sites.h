/* The sites of a .qcf, one after another, with the labels and the variables of each
 * (docs/FORMAT.md, side chunks labl and kept). */
#ifndef QS_SITES_H
#define QS_SITES_H

#include "../../include/qstereo/qubo.h"
#include "../base/bytes.h"

/* Whether a cell of a grid is no site. `mask` as in qs_labels; NULL = all are. */
static inline bool qs_is_masked(const uint8_t *mask, uint32_t cell)
{
    return mask && (mask[cell / 8] >> cell % 8 & 1) == 0;
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

static inline bool qs_is_cut(qs_encoding encoding)
{
    return encoding == QS_ST_CUT || encoding == QS_ST_CUT_ARCS;
}

/* Variables of an undecided site with `count` labels left. */
static inline uint32_t qs_site_variables(qs_encoding encoding, uint32_t count)
{
    return encoding == QS_DOMAIN_WALL ? count - 1 : qs_is_cut(encoding) ? count + 1 : count;
}

/* A site. The cursor stands before the first one when only `labels` is set. */
typedef struct qs_site {
    const qs_labels *labels;
    uint32_t next; /* number of the site after this one */
    uint32_t next_number; /* and of the undecided site after it */
    uint64_t next_variable;
    /* This site: */
    uint32_t number; /* among the undecided ones, if it is one */
    uint32_t count; /* labels left; 1 = it is fixed, unless the problem has one label and no chunk
                       kept */
    uint32_t fixed; /* the label of a fixed site */
    uint64_t variable; /* its first one */
    bool is_undecided;
    const uint8_t *set; /* of an undecided site; NULL = all labels */
} qs_site;

/* The next site; false after the last. */
bool qs_site_next(qs_site *site);

/* An undecided site by its number among them, with its set alone: enough for the functions below. */
static inline qs_site qs_undecided_site(const qs_labels *labels, uint32_t number)
{
    const uint8_t *set =
        labels->fixed_bytes > 0 ? labels->sets + (size_t)number * ((labels->labels + 7) / 8) : NULL;
    return (qs_site){.labels = labels, .number = number, .is_undecided = true, .set = set};
}

/* Whether a label is left. */
static inline bool qs_site_has(const qs_site *site, uint32_t label)
{
    return !site->is_undecided ? label == site->fixed
                               : !site->set || (site->set[label / 8] >> label % 8 & 1) != 0;
}

/* The first label left from `label` on; as many as there are labels = none. */
static inline uint32_t qs_site_label(const qs_site *site, uint32_t label)
{
    while (label < site->labels->labels && !qs_site_has(site, label)) {
        label++;
    }
    return label;
}

#endif
