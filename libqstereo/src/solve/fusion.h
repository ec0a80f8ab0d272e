/* Fusion moves (Lempitsky, Rother, Roth and Blake 2010): each site keeps its label or takes that of
 * a proposal, and the choice is a minimum cut. For every pairwise cost, and no move raises F.
 *
 * An edge costs E(keep, keep), E(keep, take) and so on. Where
 *
 *     E(keep, keep) + E(take, take) <= E(keep, take) + E(take, keep)
 *
 * it is a part of a cut. Else E(keep, keep) counts as less, so much that both sides are equal
 * (Rother, Kumar, Kolmogorov and Blake 2005). So the cut has F(y) less d(y) for a choice y, and d
 * is largest where all keep their labels. If the cut finds y below `all keep` by g, F
 * falls by g or more.
 */
#ifndef QS_FUSION_H
#define QS_FUSION_H

#include "../../include/qstereo/solve.h"

#include "mover.h"

typedef struct qs_fusion {
    qs_mover m; /* its energy is that of the present labelling */
    uint16_t *proposal; /* the caller fills it in before each move */
    const qs_solve_options *options;
    qs_solution *solution; /* what the watch is told during a cut, */
    qs_reporter reporter; /* by this, */
    qs_look look; /* in these looks */
} qs_fusion;

/* Takes memory. m.model is set. */
void qs_fusion_take(qs_fusion *fusion, qs_arena *arena);

/* Whether the costs are small enough for numbers of this width. In 64 bits they always are. */
bool qs_fusion_fits(const qs_model *model);

/* Begins, with m.x and the last two fields set. The costs fit. */
void qs_fusion_start(qs_fusion *fusion);

/* The best choice. Labels that are not left to their site are not taken.
 *
 * gain  out: by how much F falls, 0 = the labelling stays
 * Returns false where the watch stopped it; then the labelling stays. */
bool qs_fuse(qs_fusion *fusion, int64_t *gain);

/* Makes the proposal that all sites jump by a step. Those that it would take beyond the labels
 * stay. */
void qs_propose_jump(qs_fusion *fusion, int32_t step);

enum { QS_JUMPS = 14 };

typedef enum qs_fusion_kind {
    QS_FUSION_EXPANSION, /* to each label in turn */
    QS_FUSION_SWAP, /* of each pair of labels in turn */
    QS_FUSION_JUMPS /* jumps by 1, 2, 3, 4, 6, 8 and 12, up and down; then to each label, where
                       there are at most 32 */
} qs_fusion_kind;

/* Moves until none of them gains. As a qs_solver; an iteration is a cycle of all moves. Returns
 * QS_OK or QS_E_WORKSPACE. */
qs_status qs_fusion_moves(qs_fusion_kind kind, const qs_model *model,
                          const qs_solve_options *options, void *workspace, size_t workspace_size,
                          uint16_t *labelling, qs_solution *solution);
size_t qs_fusion_moves_workspace(const qs_model *model);

/* The same in 64 bits, to which it hands over where costs are too large (number.h). */
qs_status qs_fusion_moves_64(qs_fusion_kind kind, const qs_model *model,
                             const qs_solve_options *options, void *workspace,
                             size_t workspace_size, uint16_t *labelling, qs_solution *solution);
size_t qs_fusion_moves_workspace_64(const qs_model *model);

#endif
