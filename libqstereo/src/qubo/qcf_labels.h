/* Reading the side chunks of a .qcf. */
#ifndef QS_QCF_LABELS_H
#define QS_QCF_LABELS_H

#include "../../include/qstereo/qubo.h"
#include "../files/container.h"

/* Reads all side chunks that there are into qubo->labels; false at a fault, which the reader notes.
 * All other chunks have been read. */
bool qs_labels_read(qs_reader *reader, qs_qubo *qubo);

#endif
