/* The problem that is left once labels have gone: open sites with two labels or more, everything
 * else folded into their costs and a constant. */
#ifndef QS_REMAINING_H
#define QS_REMAINING_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"
#include "../encode/penalty.h"
#include "../files/container.h"

/* How much is left. */
typedef struct qs_left_counts {
    uint64_t sites; /* of the problem: the model's without the masked cells */
    uint64_t open; /* of them */
    uint64_t labels; /* left to the open sites */
    uint64_t edges; /* between open sites */
    uint64_t thresholds; /* over these edges: label boundaries that may lie between their sites'
                            labels */
    bool whole; /* no label is missing */
    bool empty; /* some site has no label at all */
} qs_left_counts;

/* kept  as in qs_recode_options
 * one   whether a problem with one label, none missing, has open sites of one label */
qs_left_counts qs_left_count(const qs_model *model, const uint8_t *kept, bool one);

enum { QS_NO_SITE = -1 };

typedef struct qs_left {
    const qs_model *model;
    qs_left_counts counts;
    int64_t constant;
    bool overflow; /* a cost does not fit */
    bool no_model; /* nor into a model of the file: some label's, excess included, is above 2^31 - 1
                    */
    bool cut; /* some excess is not 0 */
    int64_t *cost; /* of each label left to each open site; each site's least is 0 */
    qs_site_edges *reach; /* of each open site */
    qs_edge *edges; /* between open sites, numbered as such; weights of 0 only where the problem is
                       whole */
    uint32_t *excess; /* of each such label: what truncation has taken from its cost; NULL = none */
    uint32_t *start; /* open + 1: where each open site's labels begin */
    uint32_t *cell; /* of each open site the model's */
    int32_t *number; /* of each of the model's sites the open one, or QS_NO_SITE */
    uint16_t *fixed; /* of each of the model's sites that is not open: its label */
    uint16_t *label; /* the labels left, rising, one open site's after another */
} qs_left;

/* Bytes of workspace, a multiple of 8. */
uint64_t qs_left_workspace(const qs_model *model, const qs_left_counts *counts, bool truncate);

/* No site is empty. */
qs_left qs_left_make(const qs_model *model, const uint8_t *kept, const qs_left_counts *counts,
                     bool truncate, void *workspace);

static inline uint32_t qs_left_size(const qs_left *left, uint32_t open)
{
    return left->start[open + 1] - left->start[open];
}

/* Whether the labels left to a site are neighbours. */
static inline bool qs_left_is_range(const qs_left *left, uint32_t open)
{
    return left->label[left->start[open + 1] - 1] - left->label[left->start[open]] ==
           (int)qs_left_size(left, open) - 1;
}

/* Side chunks of the file, and of labl what stands before the mask. */
void qs_put_labl_fields(qs_writer *writer, const qs_labels *labels, bool masked);
void qs_put_labl(qs_writer *writer, const qs_labels *labels);
void qs_put_kept(qs_writer *writer, const qs_left *left);
void qs_put_trnc(qs_writer *writer, const qs_left *left);

#endif
