#include "metric.h"

bool qs_is_semi_metric(const qs_model *model)
{
    uint32_t labels = model->labels;
    const int32_t *table = model->pairwise.table;
    if (model->pairwise.smoothness != QS_TABLE) {
        return model->pairwise.smoothness < QS_TABLE;
    }
    for (size_t a = 0; a < labels; a++) {
        for (size_t b = 0; b < a; b++) {
            if (table[a * labels + b] != table[b * labels + a] || table[a * labels + b] < 0) {
                return false;
            }
        }
        if (table[a * labels + a] != 0) {
            return false;
        }
    }
    return true;
}

/* V(a, c) <= V(a, b) + V(b, c) in a table that is a semi-metric. */
static bool table_is_metric(const int32_t *table, size_t labels)
{
    for (size_t a = 0; a < labels; a++) {
        for (size_t b = 0; b < labels; b++) {
            int64_t ab = table[a * labels + b];
            for (size_t c = 0; c < labels; c++) {
                if (table[a * labels + c] > ab + table[b * labels + c]) {
                    return false;
                }
            }
        }
    }
    return true;
}

bool qs_is_metric(const qs_model *model)
{
    uint32_t truncation = model->pairwise.truncation;
    switch (model->pairwise.smoothness) {
    case QS_POTTS:
    case QS_TRUNCATED_LINEAR: return true;
    /* V(2) <= 2 V(1) where there is a distance of 2; truncated at 1 or 2 it is linear. */
    case QS_TRUNCATED_QUADRATIC: return model->labels <= 2 || truncation == 1 || truncation == 2;
    case QS_TABLE:
    case QS_TABLES: break;
    }
    return qs_is_semi_metric(model) && table_is_metric(model->pairwise.table, model->labels);
}
