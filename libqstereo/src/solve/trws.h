/* The passes of TRW-S over the messages, and what they prove.
 *
 * Of the two messages of an edge only the newer one is kept, as Kolmogorov (2006, section 3.5)
 * allows: going forward a site has new messages from its earlier neighbours and old ones from its
 * later ones, which it replaces.
 *
 * The bound costs nothing and is exact. Let That be a site's unary costs and all messages to it. A
 * pass splits That into whole numbers X for the row's chain and Y for the column's (n parts for the
 * n chains through a site of a general graph), X + Y = That. The row's chain is then charged X less
 * the two messages along the row, the column's Y less the two along the column: in all the unary
 * costs, whatever the messages are. The least cost of the row is found by dynamic programming; its
 * next step, X less the message that came back, is minimised over the edge and normalised - which
 * is the message that the pass sends anyway. So the sum of what the messages' normalisation
 * subtracts, and of the least at the end of each chain, is the sum of the least costs of all
 * chains: a bound of 2^shift times the least energy, in integers (docs/MATHS.md, section 7). */
#ifndef QS_TRWS_H
#define QS_TRWS_H

#include "messages.h"

/* The state between passes. */
typedef struct qs_trws_state {
    const qs_model *model;
    qs_scale scale;
    bool wide; /* AVX2 */
    int32_t *messages; /* of a grid: of each site that to or from its right neighbour, then that of
                          its lower one; else of each edge */
    int32_t *scratch;
    const uint32_t *visits; /* sites that the passes visit, in order; NULL = all. The others have no
                               edges and a label that costs 0: they add nothing */
    uint32_t visit_count;
} qs_trws_state;

static inline uint32_t qs_trws_visits(const qs_trws_state *state)
{
    return state->visits ? state->visit_count : state->model->sites;
}

/* The site that a pass visits as number `at`. */
static inline uint32_t qs_trws_site(const qs_trws_state *state, uint32_t at, bool forward)
{
    at = forward ? at : qs_trws_visits(state) - 1 - at;
    return state->visits ? state->visits[at] : at;
}

/* In 64 bits, for they may not fit a size_t: numbers of messages, less of padding before them, and
 * of scratch. */
uint64_t qs_trws_messages(const qs_model *model);
uint64_t qs_trws_padding(const qs_model *model);
size_t qs_trws_scratch(const qs_model *model);

/* A pass in the order of the sites, or against it. Returns the bound on the least energy, less the
 * model's constant, times 2^shift. */
int64_t qs_trws_grid_pass(const qs_trws_state *state, bool forward);
int64_t
qs_trws_wide_pass(const qs_trws_state *state,
                  bool forward); /* of a grid with Potts costs and at least 8 labels, by AVX2 */
int64_t qs_trws_graph_pass(const qs_trws_state *state, bool forward);

/* Iterations, forward and backward. */
void qs_trws_iterate(const qs_trws_state *state, uint64_t times);

/* From now on the passes visit these sites alone. What was sent along edges whose weight has become
 * 0 is forgotten: the sites not visited would not put it right. */
void qs_trws_visit_only(qs_trws_state *state, const uint32_t *sites, uint32_t count);

/* An iteration that tells too what each label costs above the least: every labelling w that has
 * label d at site p has bound + excess_p(d) <= 2^shift (F(w) - the model's constant), where the
 * bound is that of the pass forward. The same holds of every part of the problem that no edge joins
 * to the rest, with the shares of its sites in the bound.
 *
 * In the forward pass each chain's costs are at hand as the dynamic program from its beginning has
 * them. A sweep back over the same costs gives each label's min-marginal on its chain; the excess
 * is that less the chain's least, summed over the chains through the site.
 *
 * excess   out: sites x labels (of sites visited), at most UINT32_MAX; then workspace, in all
 * qs_trws_excess_numbers shares   out: each visited site's share in the bound */
void qs_trws_excess(const qs_trws_state *state, uint32_t *excess, int64_t *shares);
uint64_t qs_trws_excess_numbers(const qs_model *model);

void qs_trws_grid_excess(const qs_trws_state *state, uint32_t *excess,
                         int64_t *shares); /* their forward passes */
void qs_trws_graph_excess(const qs_trws_state *state, uint32_t *excess, int64_t *shares);

/* qs_trws, whose state the caller sees: when a watch is called it is that between two iterations.
 * The costs and the constant of the model may be changed there, and the visits set. */
qs_status qs_trws_watched(const qs_model *model, const qs_solve_options *options, void *workspace,
                          size_t workspace_size, uint16_t *labelling, qs_solution *solution,
                          qs_trws_state *state);

/* A labelling, in the order of the sites after a pass against it, or against it after a pass in it:
 * see decode.h. */
void qs_trws_grid_labels(const qs_trws_state *state, bool forward, uint16_t *labelling);
void qs_trws_graph_labels(const qs_trws_state *state, bool forward, uint16_t *labelling);

#endif
