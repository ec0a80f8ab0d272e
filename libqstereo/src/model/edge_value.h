/* The pairwise cost of an edge of a model, whether all edges share V or each has a table of its
 * own. */
#ifndef QS_EDGE_VALUE_H
#define QS_EDGE_VALUE_H

#include <stdbool.h>

#include "../../include/qstereo/model.h"
#include "../problem/pairwise.h"

/* The number of the edge from a cell of a grid to its right neighbour or its lower one. */
static inline uint32_t qs_cell_edge(uint32_t cell, bool down)
{
    return 2 * cell + down;
}

/* The table of an edge, labels x labels. Of QS_TABLE and QS_TABLES only. */
static inline const int32_t *qs_edge_table(const qs_model *model, uint32_t edge)
{
    size_t entries = (size_t)model->labels * model->labels;
    return model->tables ? model->tables + model->table_of[edge] * entries : model->pairwise.table;
}

/* V(a, b) of an edge, without its weight. */
static inline int64_t qs_edge_value(const qs_model *model, uint32_t edge, uint32_t a, uint32_t b)
{
    if (model->tables) {
        return qs_edge_table(model, edge)[(size_t)a * model->labels + b];
    }
    return qs_pairwise_value(&model->pairwise, model->labels, a, b);
}

/* The largest V of an edge. */
static inline int64_t qs_edge_most(const qs_model *model, uint32_t edge)
{
    return model->tables ? model->table_max[model->table_of[edge]] : model->pairwise_max;
}

#endif
