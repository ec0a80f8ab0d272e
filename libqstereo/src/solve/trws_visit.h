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
    const int32_t *unary, *row_in, *column_in;
    int32_t *row_out, *column_out;
    int32_t row_weight, column_weight; /* of the edges to later sites, scaled */
    uint32_t row_edge, column_edge; /* their numbers */
    int32_t row_share; /* all bits 1: the row's chain takes a part; 0: the column's takes all */
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
    unsigned shift = state->scale.shift;
    uint32_t width = model->width;
    int32_t right = model->right[site], down = model->down[site];
    int32_t left = qs_weight_before(model->right, site, 1),
            up = qs_weight_before(model->down, site, width);
    int32_t *own = state->messages + 2 * (size_t)labels * site, *before = own - 2 * (size_t)labels,
            *above = own - 2 * (size_t)labels * width + labels;
    qs_visit v = {.unary = model->unary + (size_t)labels * site};
    v.row_in = forward ? before : own;
    v.row_out = forward ? own : before;
    v.column_in = forward ? above : own + labels;
    v.column_out = forward ? own + labels : above;
    v.row_weight = (forward ? right : left) << shift;
    v.column_weight = (forward ? down : up) << shift;
    v.row_edge = qs_cell_edge(forward ? site : site - 1, false);
    v.column_edge = qs_cell_edge(forward ? site : site - width, true);
    v.halves = (left != 0 && up != 0) || (right != 0 && down != 0);
    v.row_share = v.halves || v.row_weight != 0 || v.column_weight == 0 ? -1 : 0;
    return v;
}

/* What each label costs on the two chains, as they go on from here. */
QS_KERNEL void qs_visit_charge(const qs_visit *v, qs_scale scale, uint32_t labels, int32_t *row,
                               int32_t *column)
{
    for (uint32_t d = 0; d < labels; d++) {
        int32_t cost = qs_min_i32(v->unary[d], scale.most) << scale.shift;
        int32_t total = cost + v->row_in[d] + v->column_in[d] + v->row_out[d] + v->column_out[d];
        int32_t part = (total >> v->halves) & v->row_share;
        row[d] = part - v->row_out[d];
        column[d] = total - part - v->column_out[d];
    }
}

#endif
