#include "qubo_energy.h"

#include "../base/bits.h"

/* What the couplings of `variable` with one neighbour of its group cost in a sample in which it is
 * 1. The neighbour is not the group itself. */
static int64_t near_energy(const qs_index *index, const uint8_t *bits, uint32_t group,
                           uint32_t variable, const qs_neighbour *near)
{
    uint32_t own = variable - index->start[group], base = index->start[near->group],
             end = index->start[near->group + 1];
    int64_t sum = 0;
    for (uint32_t i = qs_bit_next(bits, base, end); i < end; i = qs_bit_next(bits, i + 1, end)) {
        sum += qs_near_entry(index, near, own, i - base);
    }
    return sum * near->weight;
}

int64_t qs_field(const qs_index *index, const uint8_t *bits, uint32_t group, uint32_t variable)
{
    int64_t cost = qs_qubo_linear(index->qubo, variable);
    for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
        cost += index->near[n].group == group
                    ? 0
                    : near_energy(index, bits, group, variable, &index->near[n]);
    }
    return cost;
}

/* What a group couples with itself: pairs above the diagonal only. */
static int64_t own_energy(const qs_index *index, const uint8_t *bits, uint32_t group,
                          uint32_t variable, const qs_neighbour *near)
{
    uint32_t base = index->start[group], end = index->start[group + 1];
    int64_t sum = 0;
    for (uint32_t i = qs_bit_next(bits, variable + 1, end); i < end;
         i = qs_bit_next(bits, i + 1, end)) {
        sum += qs_index_block(index, near->block, variable - base, i - base);
    }
    return sum * near->weight;
}

static int64_t group_energy(const qs_index *index, const uint8_t *bits, uint32_t group)
{
    uint32_t from = index->start[group], end = index->start[group + 1];
    int64_t a, b, hot = 0, energy = 0;
    for (uint32_t i = qs_bit_next(bits, from, end); i < end; i = qs_bit_next(bits, i + 1, end)) {
        hot++;
        energy += qs_qubo_linear(index->qubo, i);
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group == group) {
                energy += own_energy(index, bits, group, i, near);
            } else if ((near->block & QS_TRANSPOSED) == 0) { /* each pair of groups once */
                energy += near_energy(index, bits, group, i, near);
            }
        }
    }
    qs_index_penalty(index, group, &a, &b);
    return energy + a * (1 - hot) + b * (hot * (hot - 1) / 2);
}

int64_t qs_qubo_energy(const qs_index *index, const uint8_t *bits)
{
    int64_t energy = index->qubo->offset;
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        energy += group_energy(index, bits, g);
    }
    return energy;
}
