/* The ways to make a sample feasible without raising H (docs/MATHS.md): each for some of the
 * encodings. Each takes its workspace's size in bytes from the function above it. */
#ifndef QS_REPAIR_H
#define QS_REPAIR_H

#include "../../include/qstereo/qubo.h"

/* Potts in a domain wall, or in one-hot-sparse without empty groups: one order of all labels
 * decides for all sites. */
size_t qs_order_workspace(const qs_index *index);
void qs_repair_order(const qs_index *index, uint8_t *bits, void *workspace);

/* A domain wall, or one-hot-sparse without empty groups: each site in turn takes the candidate that
 * is cheapest beside what is expected of the others. */
size_t qs_site_by_site_workspace(const qs_index *index);
void qs_repair_site_by_site(const qs_index *index, uint8_t *bits, void *workspace);

/* Linear costs in a domain wall or a cut: the steps that no labelling has are shifted until they
 * vanish. */
size_t qs_thresholds_workspace(const qs_index *index);
void qs_repair_thresholds(const qs_index *index, uint8_t *bits, void *workspace);

/* A domain wall of any V: every site takes its first candidate, or every site its last, or as many
 * ones as it has; or as site by site. What costs least. */
size_t qs_choice_workspace(const qs_index *index);
void qs_repair_choice(const qs_index *index, uint8_t *bits, void *workspace);

#endif
