/* Proves that the couplings of a .qcf are what its encoding makes of the pairwise cost. Only then
 * is there a model of it. */
#ifndef QS_MODEL_CHECK_H
#define QS_MODEL_CHECK_H

#include "../../include/qstereo/model.h"
#include "../problem/pairwise.h"

/* A model under construction, with its arrays, to be written. */
typedef struct qs_building {
    const qs_index *index;
    const qs_labels *labels;
    qs_model model;
    int32_t *unary, *right, *down, *table;
    /* Tables of edges: one for each block of a whole problem, else one for each coupling. */
    int32_t *tables, *table_max;
    uint32_t *table_of;
    uint32_t table_count;
    uint32_t *link_start, *cursor;
    qs_link *links;
    uint32_t *site_of; /* of each group: its site in the model */
    uint8_t *kept;
    int64_t tau; /* the most that two labels cost: what a sparse block leaves out */
} qs_building;

/* The first label at or after `label` that is left to a site. The number of labels = none. */
static inline uint32_t qs_next_label_of(const qs_building *b, uint32_t site, uint32_t label)
{
    const uint8_t *kept = b->kept + (size_t)site * b->labels->labels;
    while (b->model.kept && label < b->labels->labels && !kept[label]) {
        label++;
    }
    return label;
}

/* The same of a group's site. */
static inline uint32_t qs_next_label(const qs_building *b, uint32_t group, uint32_t label)
{
    return qs_next_label_of(b, b->site_of[group], label);
}

static inline bool qs_has_walls(const qs_building *b)
{
    return b->labels->encoding == QS_DOMAIN_WALL;
}

/* How many labels are left to a group's site. */
static inline uint32_t qs_labels_left(const qs_building *b, uint32_t group)
{
    return b->index->start[group + 1] - b->index->start[group] + qs_has_walls(b);
}

static inline int64_t qs_value(const qs_building *b, uint32_t d, uint32_t e)
{
    return qs_pairwise_value(&b->model.pairwise, b->labels->labels, d, e);
}

/* Compares all blocks with the pairwise cost, those of the chains of walls too. Returns true if
 * they agree. The sites have been placed. A table of pairwise costs is gathered on the way: before,
 * all of b->table is -1. */
bool qs_couplings_agree(const qs_building *b);

/* Ends the gathering of the table. Returns false if the file holds no table of costs. */
bool qs_finish_table(const qs_building *b);

/* Copies the entries of a block that couples two sites into a table of an edge, labels x labels; 0
 * for labels that are out. In a domain wall: what its entries add up to. Returns false if one is
 * below 0, or too large. */
bool qs_copy_table(const qs_building *b, uint32_t block, uint32_t first, uint32_t second,
                   int32_t *table);

#endif
