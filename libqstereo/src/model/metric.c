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

/* V(a, c) <= V(a, b) + V(b, c) in a table that is a semi-metric. As it is symmetric, labels c above
 * a are enough; and none of its entries is below 0, so that differences have 32 bits. The innermost
 * loop has no branch: there are labels^3 steps. */
static bool table_is_metric(const int32_t *table, size_t labels)
{
    for (size_t a = 0; a < labels; a++) {
        const int32_t *of_a = table + a * labels;
        int32_t over = 0;
        for (size_t b = 0; b < labels; b++) {
            const int32_t *of_b = table + b * labels, ab = of_a[b];
            for (size_t c = a + 1; c < labels; c++) {
                over |= of_a[c] - of_b[c] > ab;
            }
        }
        if (over != 0) {
            return false;
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
