/* The passes of TRW-S in 16 bits, and the labelling after them, in parts that may be done at the
 * same time. */
#ifndef QS_TRWS16_WAVE_H
#define QS_TRWS16_WAVE_H

#include "trws16_state.h"

enum {
    QS_TRWS16_BAND = 4, /* rows of a tile */
    QS_TRWS16_BLOCKS = 8, /* tiles in a row, at most */
    QS_TRWS16_PARTS = QS_TRWS16_BLOCKS + QS_TRWS16_BAND, /* at the same time, at most */
    QS_TRWS16_FLIGHT = QS_TRWS16_BAND * (QS_TRWS16_BLOCKS + 1) /* rows in work, at most */
};

/* Does all parts of a work: the caller's threads do, or this one. */
void qs_trws16_together(const qs_solve_options *options, qs_part *part, void *work, uint32_t parts);

/* Rows in work at the same time, of passes in which the rows before are done. */
uint32_t qs_trws16_flight(const qs_trws16_state *s, const qs_solve_options *options);

/* A pass over all sites. Returns the bound, in units of 1 / 2^shift; there is none if the watch
 * stops the pass. */
int64_t qs_trws16_pass(qs_trws16_state *s, const qs_solve_options *options, bool forward);

/* A labelling in the order of the sites, each with the labels of those before it and the messages
 * of those after it. */
void qs_trws16_label(const qs_trws16_state *s, const qs_solve_options *options,
                     uint16_t *labelling);

#endif
