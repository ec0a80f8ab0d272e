/* TRW-S and moves together, for a guest that makes the problem smaller on the way. */
#ifndef QS_MESSAGES_AND_MOVES_H
#define QS_MESSAGES_AND_MOVES_H

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

/* Runs TRW-S. After iteration 8, and then whenever the iterations have doubled and have taken about
 * as long as the moves before, moves improve the labelling that TRW-S has reached: expansion, or,
 * if the pairwise cost is not a metric, jumps of all labels and moves to each label. TRW-S comes
 * first because in any given time it gets lower than expansion from the winner's labelling. It ends
 * when the bound is as near to the best labelling as options->gap asks for; that is what
 * `converged` says. The arguments are those of a solver (solve.h), but a witness is the guest's
 * affair. Costs must fit the messages of this compilation. */
qs_status qs_messages_and_moves(const qs_model *model, const qs_solve_options *options,
                                const qs_guest *guest, void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution);
size_t qs_messages_and_moves_workspace(const qs_model *model);

#endif
