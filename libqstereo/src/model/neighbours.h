/* A site and its neighbours: what each label costs there. */
#ifndef QS_NEIGHBOURS_H
#define QS_NEIGHBOURS_H

#include "../../include/qstereo/model.h"

/* An edge as one of its two sites sees it. */
typedef struct qs_edge_seen {
    uint32_t site; /* the other one */
    int32_t weight;
    uint32_t edge; /* its number, as in qs_model_edge_pairwise */
    bool first; /* the site that sees it has the lower number of the two */
} qs_edge_seen;

/* Edge `at` (0, 1, ...) of a site. Returns false after the last. Edges of weight 0 may be among
 * them; then edge->site is some site that exists. */
bool qs_see_edge(const qs_model *model, uint32_t site, uint32_t at, qs_edge_seen *edge);

/* How many edges a site has, those of weight 0 among them. */
static inline uint32_t qs_edges_at(const qs_model *model, uint32_t site)
{
    return model->width > 0 ? 4 : model->link_start[site + 1] - model->link_start[site];
}

/* Numbers that are looked at to find the best label of a site. */
static inline uint64_t qs_work_at(const qs_model *model, uint32_t site)
{
    uint64_t edges = qs_edges_at(model, site), labels = model->labels;
    bool few = model->pairwise.smoothness == QS_POTTS && edges < labels;
    return labels + edges * (few ? edges : labels);
}

/* Whether an edge of a grid, of weight above 0, leads up or down. */
static inline bool qs_is_vertical(const qs_edge_seen *edge)
{
    return edge->edge % 2 == 1; /* qs_cell_edge */
}

/* The most that a site's edges can cost: the largest V of each times its weight. At most
 * 2^QS_MODEL_BITS. */
int64_t qs_most_of_edges(const qs_model *model, uint32_t site);

/* What an edge costs with a label at the site that sees it, and another at the other site. */
int64_t qs_seen_cost(const qs_model *model, const qs_edge_seen *edge, uint32_t label,
                     uint32_t other);

/* Returns true if a site has more neighbours than there are labels. Then it is less work to go
 * through the labels than through the neighbours. Never on a grid. */
bool qs_has_many_neighbours(const qs_model *model, uint32_t site);

/* What a label costs at a site: its unary cost, and the edges to the neighbours as they are
 * labelled. */
int64_t qs_label_cost(const qs_model *model, const uint16_t *labelling, uint32_t site,
                      uint16_t label);

/* The cheapest label of a site, given the labels of its neighbours; of equals the lowest. */
uint16_t qs_best_label(const qs_model *model, const uint16_t *labelling, uint32_t site);

/* Gives a site its cheapest kept label if the label that it has is not kept. Returns true if it
 * did. model->kept is there. */
bool qs_take_kept_label(const qs_model *model, uint16_t *labelling, uint32_t site);

/* The same at every site in turn. Returns by how much the energy falls. Every solver does this to
 * what it returns: if it is stopped early it may be on its way through labels that are not kept. */
int64_t qs_take_kept_everywhere(const qs_model *model, uint16_t *labelling);

/* Returns true if every label of a labelling is one of the model's. */
bool qs_labels_in_range(const qs_model *model, const uint16_t *labelling);

#endif
