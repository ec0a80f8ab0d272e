/* The side chunks labl and mean: what the variables of a QUBO and its labels stand for
 * (docs/FORMAT.md). */
#ifndef QS_LABL_CHUNK_H
#define QS_LABL_CHUNK_H

#include "../../include/qstereo/labels.h"
#include "../files/container.h"

/* How many chunks qs_put_labl puts: labl, and mean unless the labels are disparities in whole
 * pixels. */
uint32_t qs_labl_chunks(const qs_meaning *meaning);

/* Puts the chunks.
 *
 * cells  the mask as qs_grid has it, a byte for each cell; NULL = labels->mask, which has the bits
 *        of the file */
void qs_put_labl(qs_writer *writer, const qs_labels *labels, const uint8_t *cells);

#endif
