/* The variables behind those of the sites (coding.h, qs_auxiliaries), and which groups are
 * one-hot. */
#ifndef QS_TERMINALS_H
#define QS_TERMINALS_H

#include "../../include/qstereo/qubo.h"

/* Returns true if a group has a penalty: then exactly one of its variables has to be 1. */
bool qs_is_one_hot(const qs_index *index, uint32_t group);

/* Gives terminals, source and sink the values that they have in every labelling, and each arc the
 * value that costs least beside its two ends. The file has labels.
 *
 * end  the first variable behind those of the sites */
void qs_set_auxiliary_bits(const qs_index *index, uint32_t end, uint8_t *bits);

#endif
