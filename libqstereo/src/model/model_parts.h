/* What the two makers of a model share: one reads a .qcf, the other a problem in memory. */
#ifndef QS_MODEL_PARTS_H
#define QS_MODEL_PARTS_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"

/* The largest V of two labels. Of QS_TABLES: that of all edges' tables. */
int64_t qs_largest_pairwise(const qs_model *model);

/* Finds the largest entry of each of `count` tables. */
void qs_find_table_max(const int32_t *tables, size_t count, uint32_t labels, int32_t *table_max);

/* Brings a site's costs in order once its set of labels is known: each label left costs its cost
 * less their least, which is returned; a label that is out costs one more than all edges of the
 * site can, at most 2^31 - 1. The edges are there.
 *
 * kept   sites x labels, 0 = the label is out
 * unary  sites x labels */
int32_t qs_leave_out(const qs_model *model, const uint8_t *kept, uint32_t site, int32_t *unary);

/* Returns true if no sum of costs leaves 64 bits, whatever the labels: see qs_model_build. The
 * edges and pairwise_max are there. */
bool qs_sums_fit(const qs_model *model);

/* Numbers the edges of a general graph: writes links[].edge and returns how many there are. The
 * links of each site are sorted by the other site.
 *
 * cursor  memory for one number of each site */
uint32_t qs_number_links(const uint32_t *link_start, uint32_t sites, qs_link *links,
                         uint32_t *cursor);

#endif
