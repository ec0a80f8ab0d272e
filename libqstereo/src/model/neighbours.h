/* One site beside its neighbours: what each of its labels costs there. */
#ifndef QS_NEIGHBOURS_H
#define QS_NEIGHBOURS_H

#include "../../include/qstereo/model.h"

/* A neighbour of a site; `first` = the site is the lower-numbered of the two. */
typedef struct qs_edge_seen {
    uint32_t site;
    int32_t weight;
    bool first;
} qs_edge_seen;

/* Neighbour `at` (0, 1, ...) of a site; false after the last. Neighbours of weight 0 may be among
 * them. */
bool qs_see_edge(const qs_model *model, uint32_t site, uint32_t at, qs_edge_seen *edge);

/* The most that a site's edges can cost: the largest V times the sum of their weights. */
int64_t qs_most_of_edges(const qs_model *model, uint32_t site);

/* Whether a site has more neighbours than there are labels, so that going through the labels is
 * less work. Never on a grid. */
bool qs_has_many_neighbours(const qs_model *model, uint32_t site);

/* Cost of a label at a site: its unary cost and those of the edges to the neighbours as they are
 * labelled. */
int64_t qs_label_cost(const qs_model *model, const uint16_t *labelling, uint32_t site,
                      uint16_t label);

/* The cheapest label of a site beside its neighbours; of equals the lowest. */
uint16_t qs_best_label(const qs_model *model, const uint16_t *labelling, uint32_t site);

/* Where the site's label is not kept (model->kept, which must be there), it takes the cheapest
 * beside its neighbours that is. Whether it did. */
bool qs_take_kept_label(const qs_model *model, uint16_t *labelling, uint32_t site);

/* Gives each site whose label is not left to it (model->kept) its cheapest label that is, beside
 * its neighbours as they are; by how much the energy falls. What a solver returns has passed here:
 * stopped early it may be on its way through such labels. */
int64_t qs_take_kept_everywhere(const qs_model *model, uint16_t *labelling);

/* Whether every label of a labelling is one of the model's. */
bool qs_labels_in_range(const qs_model *model, const uint16_t *labelling);

#endif
