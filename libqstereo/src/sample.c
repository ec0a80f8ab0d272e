#include "../include/qstereo/sample.h"

#include <string.h>

static bool is_set(const uint8_t *bits, uint32_t variable)
{
    return bits[variable / 8] >> variable % 8 & 1;
}

static void set(uint8_t *bits, uint32_t variable, bool value)
{
    uint8_t bit = (uint8_t)(1u << variable % 8);
    bits[variable / 8] = (uint8_t)(value ? bits[variable / 8] | bit : bits[variable / 8] & ~bit);
}

/* The next variable at 1 from `from` on, or `end`. Zero bytes, most of a sample, are passed over whole. */
static uint32_t next_set(const uint8_t *bits, uint32_t from, uint32_t end)
{
    while (from < end && !is_set(bits, from)) {
        from = bits[from / 8] >> from % 8 == 0 ? (from / 8 + 1) * 8 : from + 1;
    }
    return from < end ? from : end;
}

static uint32_t count_set(const uint8_t *bits, uint32_t from, uint32_t end)
{
    uint32_t count = 0;
    for (uint32_t i = next_set(bits, from, end); i < end; i = next_set(bits, i + 1, end)) {
        count++;
    }
    return count;
}

static bool is_one_hot(const qs_index *index, uint32_t group)
{
    int64_t a, b;
    qs_index_penalty(index, group, &a, &b);
    return a != 0 || b != 0;
}

/* What the couplings of `variable` with one neighbour of its group cost in a sample. */
static int64_t coupling(const qs_index *index, const uint8_t *bits, uint32_t group, uint32_t variable, const qs_neighbour *near)
{
    uint32_t own = variable - index->start[group], base = index->start[near->group], end = index->start[near->group + 1];
    bool turned = (near->block & QS_TRANSPOSED) != 0;
    int64_t sum = 0;
    for (uint32_t i = next_set(bits, base, end); i < end; i = next_set(bits, i + 1, end)) {
        uint32_t other = i - base;
        sum += qs_index_block(index, near->block & ~QS_TRANSPOSED, turned ? other : own, turned ? own : other);
    }
    return sum * near->weight;
}

/* What a group couples with itself: pairs above the diagonal only. */
static int64_t own_coupling(const qs_index *index, const uint8_t *bits, uint32_t group, uint32_t variable, const qs_neighbour *near)
{
    uint32_t base = index->start[group], end = index->start[group + 1];
    int64_t sum = 0;
    for (uint32_t i = next_set(bits, variable + 1, end); i < end; i = next_set(bits, i + 1, end)) {
        sum += qs_index_block(index, near->block, variable - base, i - base);
    }
    return sum * near->weight;
}

static int64_t group_energy(const qs_index *index, const uint8_t *bits, uint32_t group)
{
    uint32_t from = index->start[group], end = index->start[group + 1];
    int64_t a, b, hot = 0, energy = 0;
    for (uint32_t i = next_set(bits, from, end); i < end; i = next_set(bits, i + 1, end)) {
        hot++;
        energy += qs_qubo_linear(index->qubo, i);
        for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
            const qs_neighbour *near = &index->near[n];
            if (near->group == group) {
                energy += own_coupling(index, bits, group, i, near);
            } else if ((near->block & QS_TRANSPOSED) == 0) { /* each pair of groups once */
                energy += coupling(index, bits, group, i, near);
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

uint32_t qs_sample_infeasible(const qs_index *index, const uint8_t *bits)
{
    uint32_t infeasible = 0;
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        infeasible += is_one_hot(index, g) && count_set(bits, index->start[g], index->start[g + 1]) != 1;
    }
    return infeasible;
}

qs_status qs_sample_decode(const qs_index *index, const uint8_t *bits, uint16_t *labelling)
{
    if (!index->qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        if (count_set(bits, index->start[g], index->start[g + 1]) != 1) {
            return QS_E_INFEASIBLE;
        }
    }
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        uint32_t from = index->start[g];
        labelling[g] = (uint16_t)(next_set(bits, from, index->start[g + 1]) - from);
    }
    return QS_OK;
}

qs_status qs_sample_encode(const qs_index *index, const uint16_t *labelling, uint8_t *bits)
{
    const qs_qubo *qubo = index->qubo;
    if (!qubo->has_labels) {
        return QS_E_UNSUPPORTED;
    }
    for (uint32_t g = 0; g < qubo->groups; g++) {
        if (labelling[g] >= qubo->labels.labels) {
            return QS_E_ARGUMENT;
        }
    }
    memset(bits, 0, ((size_t)qubo->variables + 7) / 8);
    for (uint32_t g = 0; g < qubo->groups; g++) {
        set(bits, index->start[g] + labelling[g], true);
    }
    return QS_OK;
}

/* What having `variable` at 1 costs beside the neighbours as they are. */
static int64_t field(const qs_index *index, const uint8_t *bits, uint32_t group, uint32_t variable)
{
    int64_t cost = qs_qubo_linear(index->qubo, variable);
    for (uint32_t n = index->near_start[group]; n < index->near_start[group + 1]; n++) {
        cost += coupling(index, bits, group, variable, &index->near[n]);
    }
    return cost;
}

/* Leaves one variable of a group at 1: the cheapest of those at 1 now, or of all. */
static void keep_cheapest(const qs_index *index, uint8_t *bits, uint32_t group, bool of_all)
{
    uint32_t from = index->start[group], end = index->start[group + 1], best = end;
    int64_t least = 0;
    for (uint32_t i = from; i < end; i++) {
        if (of_all || is_set(bits, i)) {
            int64_t cost = field(index, bits, group, i);
            if (best == end || cost < least) {
                best = i;
                least = cost;
            }
        }
    }
    for (uint32_t i = from; i < end; i++) {
        set(bits, i, i == best);
    }
}

uint32_t qs_sample_repair(const qs_index *index, uint8_t *bits)
{
    uint32_t changed = 0;
    /* All the thinning before any filling: that order is what the proof needs. */
    for (int fill = 0; fill < 2; fill++) {
        for (uint32_t g = 0; g < index->qubo->groups; g++) {
            uint32_t hot = count_set(bits, index->start[g], index->start[g + 1]);
            if (is_one_hot(index, g) && (fill ? hot == 0 : hot > 1)) {
                keep_cheapest(index, bits, g, fill);
                changed++;
            }
        }
    }
    return changed;
}
