#include "label_sets.h"

int64_t qs_eliminate_above_in_parts(qs_elimination *e, const qs_natural *marginals,
                                    const int64_t *shares, unsigned shift, int64_t *room)
{
    uint32_t labels = e->model.labels;
    int64_t gap = qs_eliminate_find_rooms(e, shares, shift, room);
    for (uint32_t i = 0; i < e->left_count; i++) {
        uint32_t p = e->left[i];
        uint64_t most = (uint64_t)e->room[e->part[p]];
        const qs_natural *more = marginals + (size_t)p * labels;
        uint8_t *kept = e->kept + (size_t)p * labels, changed = 0;
        for (uint32_t d = 0; d < labels; d++) {
            uint8_t leaves = kept[d] & (more[d] > most);
            kept[d] ^= leaves;
            changed |= leaves;
        }
        if (changed) {
            qs_eliminate_follow_set(e, p);
        }
    }
    return gap;
}

int64_t qs_eliminate_above(qs_elimination *e, const qs_natural *marginals, const int64_t *shares,
                           unsigned shift, int64_t *room)
{
    qs_eliminate_find_parts(e);
    return qs_eliminate_above_in_parts(e, marginals, shares, shift, room);
}
