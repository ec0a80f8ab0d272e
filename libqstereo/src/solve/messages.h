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

/* What the messages of a model are computed with. */
typedef struct qs_scale {
    unsigned shift;
    /* In units. A unary cost above it counts as `most`: in no optimum has a site such a label,
     * unless its cheapest label would do as well. */
    int32_t most;
} qs_scale;

/* Chooses the finest scale of at most `shift` bits at which all sums fit 31 bits: of a unary cost,
 * of the messages to a site, and of one message more. Returns false if there is none.
 *
 * `most` is above what all edges of any one site can cost. So the least energy stays, and no energy
 * rises. Where the model has sets of labels, labels may leave these later and then cost `most`; and
 * there is room for the two messages more that qs_trws_marginals adds. */
bool qs_scale_choose(const qs_model *model, unsigned shift, qs_scale *scale);

/* Numbers of workspace that qs_message_send needs. */
size_t qs_message_scratch(const qs_model *model);

/* Computes the message along an edge. Its least number is 0; returns what was subtracted for that.
 *
 * edge     its number: see qs_model_edge_pairwise. Of weight 0: any
 * weight   of the edge, scaled
 * upward   it is sent to the higher-numbered site
 * costs    of the labels of the sender, at least -2^30; may be overwritten
 * message  out: of the labels of the receiver; not `costs`
 * scratch  qs_message_scratch numbers */
int32_t qs_message_send(const qs_model *model, uint32_t edge, int32_t weight, bool upward,
                        int32_t *costs, int32_t *message, int32_t *scratch);

/* Adds to the cost of each label d what the edge to a neighbour costs that has the label `other`:
 * weight V(other, d) if the neighbour is the lower-numbered site, else weight V(d, other). */
void qs_message_pay(const qs_model *model, uint32_t edge, int32_t weight, bool lower,
                    uint32_t other, int32_t *costs);

#endif
