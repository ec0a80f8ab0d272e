/* TRW-S, as others in the library make use of it. */
#ifndef QS_TRWS_H
#define QS_TRWS_H

#include "trws_passes.h"

/* qs_trws with a state that the caller sees. When the watch is called it is the state between two
 * iterations. The watch may then change the costs and the constant of the model, and which sites
 * are visited.
 *
 * look      asks within an iteration whether to go on; it may not change anything
 * solution  out: always what has been found so far
 *
 * Returns QS_OK, QS_E_ARGUMENT, QS_E_WORKSPACE, or QS_E_OVERFLOW: the messages do not fit. */
qs_status qs_trws_watched(const qs_model *model, const qs_solve_options *options, qs_look *look,
                          void *workspace, size_t workspace_size, uint16_t *labelling,
                          qs_solution *solution, qs_trws_state *state);

/* Iterations: each a forward and a backward pass. The state's look may stop them. */
void qs_trws_iterate(const qs_trws_state *state, uint64_t times);

/* From now on the passes visit these sites alone, which are in order. Messages on edges whose
 * weight has become 0 are set to 0: the passes no longer come to the sites that would do it. */
void qs_trws_visit_only(qs_trws_state *state, const uint32_t *sites, uint32_t count);

/* One iteration that also finds the marginal of each label: how much more than the least the chains
 * through its site cost if the site has that label. Every labelling w with label d at site p has
 *
 *     bound + marginal_p(d) <= 2^shift (F(w) - the model's constant),
 *
 * where the bound is that of the forward pass. The same holds of every part of the problem that no
 * edge joins to the rest, with the shares of the part's sites for the bound.
 *
 * The forward pass has each chain's costs up to each site, as its dynamic program goes along. A
 * sweep back over the same costs adds what comes later: these are the min-marginals of the chain.
 * Less the chain's least, and summed over the chains through the site, they are the marginals.
 *
 * marginals  out: sites x labels, of sites visited, at most QS_NATURAL_MAX; and memory behind
 *            them. In all qs_trws_marginal_numbers
 * shares     out: the share of each site visited in the bound */
void qs_trws_marginals(const qs_trws_state *state, qs_natural *marginals, int64_t *shares);
uint64_t qs_trws_marginal_numbers(const qs_model *model);

#endif
