/* What stands behind the sites in the cuts' encodings: terminals, source and sink, arcs. */
#ifndef QS_TERMINALS_H
#define QS_TERMINALS_H

#include "../../include/qstereo/qubo.h"

/* Whether a group has a penalty. */
bool qs_is_one_hot(const qs_index *index, uint32_t group);

/* Gives terminals, source and sink the values that they have in every labelling, and each arc the
 * value that costs least beside its ends: 1 where it is cut.
 *
 * end  the first variable behind the sites' */
void qs_set_auxiliary_bits(const qs_index *index, uint32_t end, uint8_t *bits);

#endif
