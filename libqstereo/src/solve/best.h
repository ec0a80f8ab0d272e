/* qs_best, as others in the library make use of it. */
#ifndef QS_BEST_H
#define QS_BEST_H

#include "trws.h"

/* Who changes the problem while it is being solved: qs_reduce. */
typedef struct qs_guest {
    /* Called after every iteration of TRW-S, the last one too, before the watch; and once more,
     * with `stopped`, after the watch has ended it. It may change the costs, the edges, the
     * constant and the label sets of the model, which sites TRW-S visits, the labelling, and so_far
     * without its iterations. Energy and bound must hold afterwards. Returns false to stop. */
    bool (*between)(void *context, qs_trws_state *state, qs_solution *so_far, bool stopped);
    void *context;
} qs_guest;

/* The same as qs_best with a guest, or without (NULL). */
qs_status qs_best_with(const qs_model *model, const qs_solve_options *options,
                       const qs_guest *guest, void *workspace, size_t workspace_size,
                       uint16_t *labelling, qs_solution *solution);

#endif
