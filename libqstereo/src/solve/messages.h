/* Messages along the edges of a model, in fixed point: a cost of one unit is 2^shift.
 *
 * A message from p to q is min over a of (cost_p(a) + weight V(a, b)) for each label b of q, less a
 * constant. Where an edge has weight 0 the message is 0: there is no edge. */
#ifndef QS_MESSAGES_H
#define QS_MESSAGES_H

#include "../../include/qstereo/solve.h"

/* What the messages of a model are computed with. */
typedef struct qs_scale {
    unsigned shift;
    int32_t most; /* a unary cost above this counts as this, in units: a label of it is in no
                     optimum that its site's cheapest would not serve as well */
} qs_scale;

/* The finest scale, of at most `shift` bits, at which sums of a unary cost, of the messages to a
 * site and of one more fit in 31 bits; false where none does. `most` is above what all edges of any
 * one site can cost, so that the least energy stays and no energy rises. Where the model has sets
 * of labels, these may lose labels later, which then cost `most`, and there is room for the two
 * messages more that qs_trws_excess adds. */
bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale);

/* Numbers of workspace that qs_message_send needs. */
size_t qs_message_scratch(const qs_model *model);

/* The message along an edge of scaled weight `weight`, normalised to least 0; returns what was
 * subtracted, the least of the message before.
 *
 * upward   sent to the higher-numbered site
 * costs    of the labels of the sender, at least -2^30; may be overwritten
 * message  out: of the labels of the receiver; not `costs`
 * scratch  qs_message_scratch numbers */
int32_t qs_message_send(const qs_model *model, int32_t weight, bool upward, int32_t *costs,
                        int32_t *message, int32_t *scratch);

/* Adds to the cost of each label d what the edge to a neighbour of the label `other` costs: weight
 * V(other, d), or V(d, other) where the neighbour is the higher-numbered of the two. */
void qs_message_pay(const qs_model *model, int32_t weight, bool lower, uint32_t other,
                    int32_t *costs);

#endif
