/* Two labellings made one that is at least as good as either (partition crossover: Tinos, Whitley
 * and Ochoa 2018). The sites where they differ fall into parts that no edge joins. Whether a part
 * is taken over changes nothing at the others, so each is decided for itself (docs/MATHS.md). */
#ifndef QS_MERGE_H
#define QS_MERGE_H

#include "../../include/qstereo/model.h"
#include "../base/arena.h"

typedef struct qs_merger {
    const qs_model *model;
    uint32_t *part; /* of each site where they differ: another one of its part, or itself */
    int64_t *rise; /* of each part, at its first site */
} qs_merger;

/* Takes memory. */
void qs_merger_take(qs_merger *merger, const qs_model *model, qs_arena *arena);

/* Takes over from `other` the parts that do not raise F: those of the same cost too, so that a
 * search moves on. Both have kept labels only.
 *
 * sites  where they may differ, in order, count of them; NULL = all
 * Returns by how much F has fallen. */
int64_t qs_merge(qs_merger *merger, const uint32_t *sites, uint32_t count, uint16_t *labelling,
                 const uint16_t *other);

#endif
