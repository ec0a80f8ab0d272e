/* qs_best, as others in the library make use of it. */
#ifndef QS_BEST_H
#define QS_BEST_H

#include "trws.h"

/* Who works on the problem while it is being solved. */
typedef struct qs_guest {
    /* Called after every iteration of TRW-S, the last one too, before the watch is told, and with
     * `stopped` once more where the watch has ended it; false = stop. It may change costs, edges,
     * constant and label sets of the model, which sites TRW-S visits, so_far (but for the
     * iterations) and the labelling, such that energy and bound hold. */
    bool (*between)(void *context, qs_trws_state *state, qs_solution *so_far, bool stopped);
    void *context;
} qs_guest;

/* The same as qs_best with a guest, or without (NULL). */
qs_status qs_best_with(const qs_model *model, const qs_solve_options *options,
                       const qs_guest *guest, void *workspace, size_t workspace_size,
                       uint16_t *labelling, qs_solution *solution);

#endif
