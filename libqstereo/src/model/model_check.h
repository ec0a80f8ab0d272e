/* Whether the couplings of a .qcf are what its encoding makes of the pairwise cost: what a model is
 * built on. */
#ifndef QS_MODEL_CHECK_H
#define QS_MODEL_CHECK_H

#include "../../include/qstereo/model.h"
#include "../problem/pairwise.h"

/* A model under construction: its arrays, to be written. */
typedef struct qs_building {
    const qs_index *index;
    const qs_labels *labels;
    qs_model model;
    int32_t *unary, *right, *down, *table;
    uint32_t *link_start, *cursor;
    qs_link *links;
    uint32_t *site_of; /* of each group: its site in the model */
    uint8_t *kept;
    int64_t tau; /* of a sparse block: what two labels cost at most */
} qs_building;

/* The first label left to a group's site from `label` on; as many as there are labels = none. */
static inline uint32_t qs_next_label(const qs_building *b, uint32_t group, uint32_t label)
{
    const uint8_t *kept = b->kept + (size_t)b->site_of[group] * b->labels->labels;
    while (b->model.kept && label < b->labels->labels && !kept[label]) {
        label++;
    }
    return label;
}

static inline bool qs_has_walls(const qs_building *b)
{
    return b->labels->encoding == QS_DOMAIN_WALL;
}

/* Labels left to a group's site. */
static inline uint32_t qs_labels_left(const qs_building *b, uint32_t group)
{
    return b->index->start[group + 1] - b->index->start[group] + qs_has_walls(b);
}

static inline int64_t qs_value(const qs_building *b, uint32_t d, uint32_t e)
{
    return qs_pairwise_value(&b->model.pairwise, b->labels->labels, d, e);
}

/* The smoothness that the encoding can hold; in a table the blocks hold the costs. */
bool qs_encoding_fits(const qs_building *b);

/* All blocks beside the pairwise cost, the chains of walls among them. The sites have been placed.
 * A table is gathered on the way: *b->table is all -1 before. */
bool qs_couplings_agree(const qs_building *b);

/* Ends the gathering of the table; false where it is none. */
bool qs_finish_table(const qs_building *b);

#endif
