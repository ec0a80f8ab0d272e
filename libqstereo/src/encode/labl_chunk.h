/* The side chunk labl: what the variables of a QUBO mean (docs/FORMAT.md). */
#ifndef QS_LABL_CHUNK_H
#define QS_LABL_CHUNK_H

#include "../../include/qstereo/labels.h"
#include "../files/container.h"

/* Puts the chunk.
 *
 * cells  the mask as qs_grid has it, a byte for each cell; NULL = labels->mask, which has the bits
 *        of the file */
void qs_put_labl(qs_writer *writer, const qs_labels *labels, const uint8_t *cells);

#endif
