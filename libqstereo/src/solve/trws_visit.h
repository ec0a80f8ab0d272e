/* What a pass of TRW-S reads and writes at a site of a grid. */
#ifndef QS_TRWS_VISIT_H
#define QS_TRWS_VISIT_H

#include "../base/minmax.h"
#include "../base/simd.h"
#include "../model/edge_value.h"
#include "trws_passes.h"

/* A site in a pass: the messages that it takes in and those that it replaces, along the row and
 * along the column. */
typedef struct qs_visit {
    size_t first; /* of the site's unary costs */
    const qs_number *row_in, *column_in;
    qs_number *row_out, *column_out;
    qs_number row_weight, column_weight; /* of the edges to later sites, scaled */
    uint32_t row_edge, column_edge; /* their numbers */
    qs_number row_share; /* all bits 1: the row's chain takes a part; 0: the column's takes all */
    unsigned halves; /* 1: both chains go on, and each takes a half; 0: one takes all */
} qs_visit;

/* The weight of the edge from the cell `back` cells before; 0 where that lies before the first. */
static inline int32_t qs_weight_before(const int32_t *weights, uint32_t site, uint32_t back)
{
    return site >= back ? weights[site - back] : 0;
}

QS_KERNEL qs_visit qs_visit_of(const qs_trws_state *state, uint32_t site, uint32_t labels,
                               bool forward)
{
    const qs_model *model = state->model;
    uint32_t width = model->width;
    int32_t right = model->right[site], down = model->down[site];
    int32_t left = qs_weight_before(model->right, site, 1),
            up = qs_weight_before(model->down, site, width);
    qs_number *own = state->messages + 2 * (size_t)labels * site,
              *before = own - 2 * (size_t)labels,
              *above = own - 2 * (size_t)labels * width + labels;
    qs_visit v = {.first = (size_t)labels * site};
    v.row_in = forward ? before : own;
    v.row_out = forward ? own : before;
    v.column_in = forward ? above : own + labels;
    v.column_out = forward ? own + labels : above;
    v.row_weight = qs_scaled_weight(state->scale, forward ? right : left);
    v.column_weight = qs_scaled_weight(state->scale, forward ? down : up);
    v.row_edge = qs_cell_edge(forward ? site : site - 1, false);
    v.column_edge = qs_cell_edge(forward ? site : site - width, true);
    v.halves = (left != 0 && up != 0) || (right != 0 && down != 0);
    v.row_share = v.halves || v.row_weight != 0 || v.column_weight == 0 ? -1 : 0;
    return v;
}

/* What each label costs on the two chains, as they go on from here. */
QS_KERNEL void qs_visit_charge(const qs_trws_state *state, const qs_visit *v, uint32_t labels,
                               qs_number *row, qs_number *column)
{
    qs_scale scale = state->scale; /* what is written below may not change it */
    for (uint32_t d = 0; d < labels; d++) {
        qs_number cost = qs_scaled_cost(state->model, scale, v->first + d);
        qs_number total = cost + v->row_in[d] + v->column_in[d] + v->row_out[d] + v->column_out[d];
        qs_number part = (total >> v->halves) & v->row_share;
        row[d] = part - v->row_out[d];
        column[d] = total - part - v->column_out[d];
    }
}

#endif
