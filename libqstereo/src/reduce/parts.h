/* The parts of a problem that is being reduced, solved one by one. */
#ifndef QS_PARTS_H
#define QS_PARTS_H

#include "../../include/qstereo/solve.h"
#include "label_sets.h"

enum { QS_PART_NODES = 4096 }; /* sites of a part that is solved, at most; also in a certificate */

/* Solves the parts that are not closed, one by one, by elimination, or by branch and bound: as far
 * as memory and work suffice. A solved part has its best labelling afterwards, and is closed. Of
 * others labels may leave, and the labelling may become better.
 *
 * memory  aligned for any type
 * work    numbers that may be looked at; out: what is left of them
 * witness NULL, or it is asked for each part whether it may be solved
 * Returns true if anything has changed. */
bool qs_parts_solve(qs_elimination *e, void *memory, size_t size, qs_allowance *work,
                    const qs_witness *witness);

/* The same for the part of site number `first` of those left, if that is the first of its part.
 * Parts have been found; label sets do not follow yet. */
bool qs_parts_solve_one(qs_elimination *e, uint32_t first, void *memory, size_t size,
                        qs_allowance *work, const qs_witness *witness);

/* Searches the parts that are not closed for better labellings; no label leaves. Arguments are as
 * above. Returns true if the labelling has changed. */
bool qs_parts_improve(qs_elimination *e, void *memory, size_t size, qs_allowance *work);

/* Asks a witness to solve the parts that are not closed, for their least energies alone: what it
 * solves stays as it is here. Returns true if it has solved any. */
bool qs_parts_prove(qs_elimination *e, void *memory, size_t size, const qs_witness *witness);

/* Bytes that are worth giving it. */
size_t qs_parts_memory(const qs_model *model);

#endif
