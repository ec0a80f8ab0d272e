#include "repair.h"

#include "../../include/qstereo/sample.h"
#include "../base/bits.h"
#include "../problem/pairwise.h"
#include "../base/bytes.h"
#include "../qubo/qubo_energy.h"
#include "../qubo/sites.h"
#include "terminals.h"

/* Leaves one variable of a group at 1: the cheapest of those at 1 now, or of all. */
static void keep_cheapest(const qs_index *index, uint8_t *bits, uint32_t group, bool of_all)
{
    uint32_t from = index->start[group], end = index->start[group + 1], best = end;
    int64_t least = 0;
    for (uint32_t i = from; i < end; i++) {
        if (of_all || qs_bit(bits, i)) {
            int64_t cost = qs_field(index, bits, group, i);
            if (best == end || cost < least) {
                best = i;
                least = cost;
            }
        }
    }
    for (uint32_t i = from; i < end; i++) {
        qs_bit_set(bits, i, i == best);
    }
}

/* All the thinning before any filling: that order is what the proof needs. */
static void thin(const qs_index *index, uint8_t *bits)
{
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        if (qs_is_one_hot(index, g) &&
            qs_bit_count(bits, index->start[g], index->start[g + 1]) > 1) {
            keep_cheapest(index, bits, g, false);
        }
    }
}

static void fill(const qs_index *index, uint8_t *bits)
{
    for (uint32_t g = 0; g < index->qubo->groups; g++) {
        if (qs_is_one_hot(index, g) &&
            qs_bit_next(bits, index->start[g], index->start[g + 1]) == index->start[g + 1]) {
            keep_cheapest(index, bits, g, true);
        }
    }
}

typedef enum way { GREEDY, ORDER, ALONE, STEPS } way;

static way way_of(const qs_qubo *qubo)
{
    const qs_labels *l = &qubo->labels;
    bool potts = l->pairwise.smoothness == QS_POTTS;
    if (!qubo->has_labels || l->encoding == QS_ONE_HOT || l->encoding == QS_MULTIWAY_CUT ||
        (l->encoding == QS_ONE_HOT_SPARSE && l->penalty != QS_PENALTY_MINIMAL)) {
        return GREEDY;
    }
    if (qs_is_cut(l->encoding) ||
        (l->encoding == QS_DOMAIN_WALL && qs_is_linear(&l->pairwise, l->labels))) {
        return STEPS;
    }
    return potts ? ORDER : ALONE;
}

static uint64_t workspace_of(const qs_index *index)
{
    switch (way_of(index->qubo)) {
    case GREEDY: return 0;
    case ORDER: return qs_order_workspace(index);
    case ALONE: return qs_alone_workspace(index);
    case STEPS: break;
    }
    return qs_steps_workspace(index);
}

size_t qs_repair_workspace(const qs_index *index)
{
    return qs_size(workspace_of(index));
}

static void repair(const qs_index *index, uint8_t *bits, void *workspace)
{
    way by = way_of(index->qubo);
    if (by == GREEDY) {
        thin(index, bits);
    }
    fill(index, bits);
    if (by == ORDER) {
        qs_repair_order(index, bits, workspace);
    } else if (by == ALONE) {
        qs_repair_alone(index, bits, workspace);
    } else if (by == STEPS) {
        qs_repair_steps(index, bits, workspace);
    }
}

qs_status qs_sample_repair(const qs_index *index, uint8_t *bits, void *workspace,
                           size_t workspace_size, uint32_t *repaired)
{
    if (!index || !bits || (!workspace && workspace_of(index) > 0)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < workspace_of(index)) {
        return QS_E_WORKSPACE;
    }
    uint32_t infeasible = qs_sample_infeasible(index, bits);
    if (infeasible > 0) {
        repair(index, bits, workspace);
    }
    qs_site end = {.labels = &index->qubo->labels};
    while (index->qubo->has_labels && qs_site_next(&end)) {
    }
    qs_set_auxiliary_bits(index, (uint32_t)end.next_variable, bits);
    if (repaired) {
        *repaired = infeasible;
    }
    return QS_OK;
}
