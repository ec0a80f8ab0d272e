/* Labels that leave because a bound is too high with them.
 *
 * A label is tried: its site may have no other, and messages go on for a while among the sites of
 * the part. If the bound rises above what the best labelling costs there, no optimum has the label.
 * That is so by the chains through its site, so a split proves it as it does for marginals
 * (docs/MATHS.md, section 19). Without such trials a part may stay that is too wide to be solved,
 * though its relaxation has no more to say. */
#ifndef QS_PROBES_H
#define QS_PROBES_H

#include "../solve/trws.h"
#include "label_sets.h"

/* What trials work on. */
typedef struct qs_probes {
    qs_elimination *e;
    qs_trws_state *state; /* the messages are the same afterwards */
    void *memory; /* aligned for any type */
    size_t size;
    const qs_witness *witness; /* NULL, or it is told of every label that leaves */
    qs_allowance *work; /* numbers that may be looked at; out: what is left of them */
    uint32_t most; /* labels that may leave; out: less those that have */
} qs_probes;

/* Tries the labels of all parts that are not closed and not too large, site by site, and solves
 * parts that have become narrow. The best labelling is there. Returns true if anything has
 * changed. */
bool qs_probes_take_out(qs_probes *probes);

#endif
