/* Messages along the edges of a model, in fixed point: a cost of one unit is 2^shift.
 *
 * The message from p to q holds, for each label b of q, the least over the labels a of p of
 *
 *     cost_p(a) + weight V(a, b),
 *
 * less the least of these. An edge of weight 0 is no edge: its message is 0. */
#ifndef QS_MESSAGES_H
#define QS_MESSAGES_H

#include "../../include/qstereo/solve.h"
#include "../base/simd.h"
#include "number.h"

/* What the messages of a model are computed with. */
typedef struct qs_scale {
    unsigned shift;
    /* In units. A unary cost above it counts as `most`: in no optimum has a site such a label,
     * unless its cheapest label would do as well. */
    qs_number most;
} qs_scale;

/* Chooses the finest scale of at most `shift` bits at which all sums fit a number: of a unary cost,
 * of the messages to a site, and of one message more. Returns false if there is none; in 64 bits
 * there always is one.
 *
 * `most` is above what all edges of any one site can cost. So the least energy stays, and no energy
 * rises. Where the model has sets of labels, labels may leave these later and then cost `most`; and
 * there is room for the two messages more that qs_trws_marginals adds. */
bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale);

/* Whether qs_scale_choose finds a scale.
 *
 * sets  whether the model has, or will get, sets of labels */
bool qs_messages_fit(const qs_model *model, bool sets);

/* Entry `at` of the model's unary costs, scaled. A label that is out cannot always cost in 31 bits
 * what keeps it out beside large edges, so in 64 bits it costs `most`. */
QS_KERNEL qs_number qs_scaled_cost(const qs_model *model, qs_scale scale, size_t at)
{
    qs_number cost = qs_min_number(model->unary[at], scale.most);
#if QS_BITS == 64
    cost = model->kept && !model->kept[at] ? scale.most : cost;
#endif
    return cost << scale.shift;
}

/* The weight of an edge, scaled. */
QS_KERNEL qs_number qs_scaled_weight(qs_scale scale, int32_t weight)
{
    return (qs_number)weight << scale.shift;
}

/* Numbers of workspace that qs_message_send needs. */
size_t qs_message_scratch(const qs_model *model);

/* Computes the message along an edge. Its least number is 0; returns what was subtracted for that.
 *
 * edge     its number: see qs_model_edge_pairwise. Of weight 0: any
 * weight   of the edge, scaled
 * upward   it is sent to the higher-numbered site
 * costs    of the labels of the sender; may be overwritten
 * message  out: of the labels of the receiver; not `costs`
 * scratch  qs_message_scratch numbers */
qs_number qs_message_send(const qs_model *model, uint32_t edge, qs_number weight, bool upward,
                          qs_number *costs, qs_number *message, qs_number *scratch);

/* Adds to the cost of each label d what the edge to a neighbour costs that has the label `other`:
 * weight V(other, d) if the neighbour is the lower-numbered site, else weight V(d, other). */
void qs_message_pay(const qs_model *model, uint32_t edge, qs_number weight, bool lower,
                    uint32_t other, qs_number *costs);

#endif
