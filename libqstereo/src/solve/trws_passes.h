/* The passes of TRW-S (Kolmogorov 2006): messages along the edges, and the lower bound.
 *
 * A pass visits the sites in order, or in reverse order. At each site it replaces the messages to
 * the neighbours that come later in the pass, from the messages of the earlier ones and the old
 * messages of the later ones. Of the two messages of an edge only the newer one is kept (section
 * 3.5).
 *
 * How the bound comes about. The grid is covered by chains: its rows and its columns. (In a general
 * graph the i-th edge to an earlier site and the i-th edge to a later site belong to the same
 * chain.) Each chain gets a share of the costs of its sites, such that the shares of a site add up
 * to its unary costs. Then the least cost of each chain alone, summed over the chains, is a lower
 * bound of the energy: one labelling of the whole costs at least as much on every chain as the best
 * labelling of that chain does.
 *
 * The messages say how the costs are shared. At a site let
 *
 *     total = unary costs + the messages to it of all its edges.
 *
 * The pass splits `total` into whole numbers, row_part + column_part = total (into n parts where n
 * chains go through a site of a general graph). The row's chain is charged row_part less the two
 * messages along the row, the column's chain column_part less the two messages along the column.
 * That is always the unary costs in all, whatever the messages are. So the bound needs no exact
 * messages, and rounding does not harm it.
 *
 * The least cost of a chain is found by dynamic programming along it. One step of that is: take the
 * costs so far, here row_part less the message that came back; minimise over the edge; subtract the
 * least. But this is just the message that the pass sends anyway. So the bound costs nothing: it is
 * the sum of what sending the messages subtracts, plus the least cost at the end of each chain. It
 * is in units of 1 / 2^shift and bounds the energy less the model's constant (docs/MATHS.md,
 * section 7). */
#ifndef QS_TRWS_PASSES_H
#define QS_TRWS_PASSES_H

#include "messages.h"
#include "progress.h"

/* The state between passes. */
typedef struct qs_trws_state {
    const qs_model *model;
    qs_scale scale;
    bool wide; /* the processor has AVX2 */
    /* Of a grid, two messages of `labels` numbers for each site: on the edge to its right
     * neighbour, then on that to its lower one. Of a graph one for each edge. */
    qs_number *messages;
    qs_number *scratch;
    /* The sites that the passes visit, in order; NULL = all. The others have no edges, and a label
     * that costs 0: they add nothing to the bound. */
    const uint32_t *visits;
    uint32_t visit_count;
    /* NULL = nothing stops a pass. A pass that is stopped leaves messages that are as good as any,
     * but no bound; labels and marginals are then not to be used. */
    qs_look *look;
} qs_trws_state;

/* How many sites a pass visits. */
static inline uint32_t qs_trws_visits(const qs_trws_state *state)
{
    return state->visits ? state->visit_count : state->model->sites;
}

/* The site that a pass visits as number `at`. */
static inline uint32_t qs_trws_site(const qs_trws_state *state, uint32_t at, bool forward)
{
    at = forward ? at : qs_trws_visits(state) - 1 - at;
    return state->visits ? state->visits[at] : at;
}

/* Numbers that are computed for each site of a pass. */
static inline uint64_t qs_trws_work(const qs_model *model)
{
    bool table = model->pairwise.smoothness >= QS_TABLE;
    return (uint64_t)model->labels * (table ? model->labels : 1);
}

/* In a loop over the sites: false if the pass is to stop. */
static inline bool qs_trws_going(const qs_trws_state *state, uint32_t at)
{
    const qs_model *model = state->model;
    uint64_t edges = model->width > 0 ? 1 : 1 + (uint64_t)model->edges / model->sites;
    return qs_look_at(state->look, at, edges * qs_trws_work(model));
}

/* Memory, in numbers of 4 bytes: of messages, of the padding before them, and of scratch. */
uint64_t qs_trws_messages(const qs_model *model);
uint64_t qs_trws_padding(const qs_model *model);
uint64_t qs_trws_scratch(const qs_model *model);

/* One pass. Returns the bound. The wide ones are for grids, with Potts or linear costs and at least
 * 8 labels, or with tables; they compute the same by AVX2. */
int64_t qs_trws_grid_pass(const qs_trws_state *state, bool forward);
int64_t qs_trws_wide_pass(const qs_trws_state *state, bool forward);
int64_t qs_trws_wide_tables_pass(const qs_trws_state *state, bool forward);
int64_t qs_trws_graph_pass(const qs_trws_state *state, bool forward);

/* Forward passes that also find the marginals: see qs_trws_marginals. */
void qs_trws_grid_marginals(const qs_trws_state *state, qs_natural *marginals, int64_t *shares);
void qs_trws_graph_marginals(const qs_trws_state *state, qs_natural *marginals, int64_t *shares);

/* A forward pass on a graph that tells a witness of the share of each chain: see qs_trws_split. */
void qs_trws_graph_split(const qs_trws_state *state, const qs_witness *witness);

/* A labelling from the messages, as label_from_messages.h says: in reverse order after a forward
 * pass, in order after a backward pass.
 *
 * forward  the order of the sites here */
void qs_trws_grid_labels(const qs_trws_state *state, bool forward, uint16_t *labelling);
void qs_trws_graph_labels(const qs_trws_state *state, bool forward, uint16_t *labelling);

#endif
