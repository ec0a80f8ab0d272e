/* What the two makers of a model share: one reads a .qcf, the other a problem in memory. */
#ifndef QS_MODEL_PARTS_H
#define QS_MODEL_PARTS_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"

/* The largest V of two labels. */
int64_t qs_largest_pairwise(const qs_model *model);

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
