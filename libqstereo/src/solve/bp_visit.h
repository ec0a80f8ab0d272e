/* A message that a site of a grid sends in a sweep of belief propagation. */
#ifndef QS_BP_VISIT_H
#define QS_BP_VISIT_H

#include "../base/simd.h"
#include "../model/edge_value.h"
#include "bp.h"

typedef struct qs_letter {
    size_t first; /* of the sender's unary costs */
    const qs_number *behind,
        *beside[2]; /* messages to the sender: from behind, and from the sides */
    qs_number *message; /* to be sent */
    qs_number weight; /* of the edge, scaled */
    uint32_t edge; /* its number */
} qs_letter;

/* The message from cell `site` to a neighbour. To the neighbour it comes from the side `from`. */
QS_KERNEL qs_letter qs_letter_of(const qs_bp_state *state, uint32_t site, uint32_t labels, int from)
{
    const qs_model *model = state->model;
    size_t each = (size_t)QS_FROM_ALL * labels;
    const qs_number *in = state->messages + each * site;
    bool along = from == QS_FROM_LEFT || from == QS_FROM_RIGHT,
         onward = from == QS_FROM_LEFT || from == QS_FROM_ABOVE;
    uint32_t step = along ? 1 : model->width, to = onward ? site + step : site - step,
             edge = onward ? site : to;
    qs_letter letter = {.first = (size_t)labels * site, .behind = in + (size_t)from * labels};
    letter.beside[0] = in + (along ? QS_FROM_ABOVE : QS_FROM_LEFT) * labels;
    letter.beside[1] = in + (along ? QS_FROM_BELOW : QS_FROM_RIGHT) * labels;
    letter.message = state->messages + each * to + (size_t)from * labels;
    letter.edge = qs_cell_edge(edge, !along);
    letter.weight = qs_scaled_weight(state->scale, along ? model->right[edge] : model->down[edge]);
    return letter;
}

#endif
