/* The ways to make a sample feasible without raising H (docs/MATHS.md): each for some of the
 * encodings. */
#ifndef QS_REPAIR_H
#define QS_REPAIR_H

#include "../../include/qstereo/qubo.h"

/* Potts, one-hot-sparse without empty groups or domain-wall: one random order of the labels for all
 * sites, made certain label by label. */
uint64_t qs_order_workspace(const qs_index *index);
void qs_repair_order(const qs_index *index, uint8_t *bits, void *workspace);

/* One-hot-sparse without empty groups or domain-wall: a random candidate for each site by itself,
 * made certain site by site. */
uint64_t qs_alone_workspace(const qs_index *index);
void qs_repair_alone(const qs_index *index, uint8_t *bits, void *workspace);

/* Linear costs in a domain-wall or a cut. */
uint64_t qs_steps_workspace(const qs_index *index);
void qs_repair_steps(const qs_index *index, uint8_t *bits, void *workspace);

#endif
