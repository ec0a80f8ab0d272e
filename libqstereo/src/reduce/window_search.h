/* A window searched by fixing sites, one at a time. */
#ifndef QS_WINDOW_SEARCH_H
#define QS_WINDOW_SEARCH_H

#include "block.h"

/* How far a labelling is above the bound, as far as that is due to one site, times 2^shift: what
 * the site and its edges to later sites cost above the least, by the messages. The sum over all
 * sites is the whole gap, and none is below 0, unless a cost is above the scale's `most`.
 *
 * state   after qs_trws_grid_marginals: the messages are those of its forward pass
 * shares  of the same */
int64_t qs_gap_at(const qs_trws_state *state, const int64_t *shares, const uint16_t *labelling,
                  uint32_t site);

/* Searches a window that is filled in, from its messages on: takes what seems to be the lowest
 * part of all labellings, and divides it by the label of a site, again and again. The bound of each
 * part is that of a few iterations of messages.
 *
 * unit   a unit of the whole's energy, in the messages' numbers
 * Returns a bound of all labellings of the window, times 2^shift. Its best labelling and the energy
 * of that are the block's afterwards. */
int64_t qs_window_search(qs_block *b, int64_t unit, qs_allowance *work);

#endif
