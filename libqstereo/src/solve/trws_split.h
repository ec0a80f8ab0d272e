/* The split of TRW-S, for a witness. */
#ifndef QS_TRWS_SPLIT_H
#define QS_TRWS_SPLIT_H

#include "trws_passes.h"

/* Tells the witness how the costs are shared among the chains. It is a forward pass; afterwards the
 * messages are those after one. Every bound of a pass that is rounded up is proven by such a split.
 *
 * labelling  the best known, of labels left */
void qs_trws_split(const qs_trws_state *state, const uint16_t *labelling,
                   const qs_witness *witness);

/* The same for the witness of a solver's options, if there is one; no label leaves. */
void qs_witness_split(const qs_trws_state *state, const qs_solve_options *options,
                      const uint16_t *labelling);

#endif
