#include "convexity.h"

#include "edge_value.h"
#include "neighbours.h"

/* Without a table: V rises with the distance and is truncated, or not within the labels. */
static bool rises_to_the_end(const qs_model *model)
{
    const qs_pairwise *pairwise = &model->pairwise;
    uint64_t most = model->labels - 1;
    if (model->labels <= 2) {
        return true;
    }
    switch (pairwise->smoothness) {
    case QS_TRUNCATED_LINEAR: return pairwise->truncation == 0 || pairwise->truncation >= most;
    case QS_TRUNCATED_QUADRATIC:
        return pairwise->truncation == 0 || pairwise->truncation >= most * most;
    default: return false;
    }
}

/* Each edge has a table. Those of more than two labels are not looked at. */
static bool tables_are_submodular(const qs_model *model)
{
    qs_edge_seen edge;
    for (uint32_t p = 0; model->labels == 2 && p < model->sites; p++) {
        for (uint32_t at = 0; qs_see_edge(model, p, at, &edge); at++) {
            if (edge.first && edge.weight > 0 &&
                qs_edge_value(model, edge.edge, 0, 0) + qs_edge_value(model, edge.edge, 1, 1) >
                    qs_edge_value(model, edge.edge, 0, 1) + qs_edge_value(model, edge.edge, 1, 0)) {
                return false;
            }
        }
    }
    return model->labels == 2;
}

bool qs_pairwise_is_submodular(const qs_model *model)
{
    if (model->tables) {
        return tables_are_submodular(model);
    }
    size_t labels = model->labels;
    const int32_t *table = model->pairwise.table;
    if (model->pairwise.smoothness != QS_TABLE) {
        return rises_to_the_end(model);
    }
    for (size_t a = 0; a + 1 < labels; a++) {
        const int32_t *row = table + a * labels, *next = row + labels;
        for (size_t b = 0; b + 1 < labels; b++) {
            if ((int64_t)row[b] + next[b + 1] > (int64_t)next[b] + row[b + 1]) {
                return false;
            }
        }
    }
    return true;
}

bool qs_pairwise_is_convex(const qs_model *model)
{
    size_t labels = model->labels;
    const int32_t *table = model->pairwise.table;
    if (!qs_pairwise_is_submodular(model)) {
        return false;
    }
    for (size_t a = 0; model->pairwise.smoothness == QS_TABLE && a + 1 < labels; a++) {
        for (size_t b = 0; b + 1 < labels; b++) {
            if (table[a * labels + b] != table[(a + 1) * labels + b + 1]) {
                return false;
            }
        }
    }
    return true;
}

bool qs_unary_is_convex(const qs_model *model)
{
    uint32_t labels = model->labels;
    for (uint32_t p = 0; p < model->sites; p++) {
        const int32_t *costs = model->unary + (size_t)p * labels;
        const uint8_t *kept = model->kept ? model->kept + (size_t)p * labels : NULL;
        uint32_t first = 0, end = labels;
        while (kept && !kept[first]) {
            first++;
        }
        while (kept && !kept[end - 1]) {
            end--;
        }
        for (uint32_t d = first + 1; d + 1 < end; d++) {
            bool hole = kept && !kept[d];
            if (hole || (int64_t)costs[d - 1] + costs[d + 1] < 2 * (int64_t)costs[d]) {
                return false;
            }
        }
    }
    return true;
}
