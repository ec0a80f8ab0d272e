#include "repair.h"

#include "../../include/qstereo/sample.h"
#include "../base/bits.h"
#include "../qubo/qubo_energy.h"
#include "../qubo/sites.h"
#include "terminals.h"

/* Leaves one variable of a group at 1: the cheapest of those at 1 now or, `of_all`, of the
 * group. */
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

/* The proof needs this order: all groups are thinned before the first is filled. */
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
        uint32_t from = index->start[g], end = index->start[g + 1];
        if (qs_is_one_hot(index, g) && qs_bit_next(bits, from, end) == end) {
            keep_cheapest(index, bits, g, true);
        }
    }
}

static qs_repair repair_of(const qs_qubo *qubo)
{
    const qs_labels *l = &qubo->labels;
    return qubo->has_labels ? qs_encoding_repair(l->encoding, l->penalty, &l->pairwise, l->labels)
                            : QS_REPAIR_BY_FLIPS;
}

size_t qs_repair_workspace(const qs_index *index)
{
    switch (repair_of(index->qubo)) {
    case QS_REPAIR_BY_FLIPS: break;
    case QS_REPAIR_BY_LABEL_ORDER: return qs_order_workspace(index);
    case QS_REPAIR_SITE_BY_SITE: return qs_site_by_site_workspace(index);
    case QS_REPAIR_BY_THRESHOLDS: return qs_thresholds_workspace(index);
    case QS_REPAIR_BY_CHOICE: return qs_choice_workspace(index);
    }
    return 0;
}

static void repair(const qs_index *index, uint8_t *bits, void *workspace)
{
    qs_repair by = repair_of(index->qubo);
    if (by == QS_REPAIR_BY_FLIPS) {
        thin(index, bits);
    }
    fill(index, bits);
    switch (by) {
    case QS_REPAIR_BY_FLIPS: break;
    case QS_REPAIR_BY_LABEL_ORDER: qs_repair_order(index, bits, workspace); break;
    case QS_REPAIR_SITE_BY_SITE: qs_repair_site_by_site(index, bits, workspace); break;
    case QS_REPAIR_BY_THRESHOLDS: qs_repair_thresholds(index, bits, workspace); break;
    case QS_REPAIR_BY_CHOICE: qs_repair_choice(index, bits, workspace); break;
    }
}

/* The first variable behind those of the sites. */
static uint32_t end_of_sites(const qs_labels *labels)
{
    qs_site site = {.labels = labels};
    while (qs_site_next(&site)) {
    }
    return (uint32_t)site.next_variable;
}

qs_status qs_sample_repair(const qs_index *index, uint8_t *bits, void *workspace,
                           size_t workspace_size, uint32_t *repaired)
{
    if (!index || !bits || (!workspace && qs_repair_workspace(index) > 0)) {
        return QS_E_ARGUMENT;
    }
    if (workspace_size < qs_repair_workspace(index)) {
        return QS_E_WORKSPACE;
    }
    uint32_t infeasible = qs_sample_infeasible(index, bits);
    if (infeasible > 0) {
        repair(index, bits, workspace);
    }
    if (index->qubo->has_labels) {
        qs_set_auxiliary_bits(index, end_of_sites(&index->qubo->labels), bits);
    }
    if (repaired) {
        *repaired = infeasible;
    }
    return QS_OK;
}
