/* A labelling problem laid out for the solvers: contiguous costs, and the graph
 * either as a grid or as lists of neighbours.
 *
 *     F(w) = constant + sum_p unary_p(w_p) + sum_{pq} weight_pq V(w_p, w_q)
 *
 * Sites of a model are the problem's, but for a masked grid: there all cells
 * are sites of the model, the masked ones without costs and edges, so that
 * every grid is a full one. */
#ifndef QSTEREO_MODEL_H
#define QSTEREO_MODEL_H

#include "qubo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An edge as one of its two sites sees it. */
typedef struct qs_link {
    uint32_t site; /* the other one */
    uint32_t
        edge; /* the edge's number, 0 .. edges - 1; in it `first` < `second` */
    int32_t weight; /* at least 0 */
} qs_link;

/* Its fields are for reading; the arrays are in the workspace that the model
 * was built in. */
typedef struct qs_model {
    uint32_t sites, labels;
    int64_t constant;
    const int32_t *unary; /* sites x labels, each site's least is 0 */
    /* sites x labels, 0 = the file has no such label at this site: its cost
     * here is above all that the site's edges can cost; NULL = all are there */
    const uint8_t *kept;
    qs_pairwise pairwise; /* the table as in qs_problem; V(a, b) with a the
                             label of the lower-numbered site */
    int64_t pairwise_max; /* the largest V */
    /* A grid: site (x, y) is y * width + x. */
    uint32_t width, height; /* 0 = no grid, and: */
    const int32_t *right; /* weight of the edge to the right neighbour, sites (0
                             in the last column) */
    const int32_t
        *down; /* and to the lower neighbour, sites (0 in the last row) */
    /* Any other graph. */
    uint32_t edges;
    const uint32_t *link_start; /* sites + 1 */
    const qs_link *links; /* 2 x edges, of each site sorted by the other */
    const uint8_t
        *mask; /* of a masked grid: a bit a cell as in qs_labels; else NULL */
} qs_model;

enum { QS_MODEL_BITS = 60 };

/* Bytes of workspace for qs_model_build. */
size_t qs_model_workspace(const qs_qubo *qubo);

/* The model of a .qcf with the encoding one-hot, one-hot-sparse or domain-wall:
 * from the file alone, so that every solver answers exactly the problem that an
 * annealer is given. Its sites and labels are those of the whole problem: a
 * site that the file has fixed has its label at cost 0 and no edges left, and a
 * label that is not left costs one more than all edges of its site can (at most
 * 2^31 - 1; the solvers' answers have none in any case). What truncating the
 * costs took is added again: energies are those of F. Edges that the file has
 * folded into other terms have weight 0 here, so only energies of labellings of
 * the labels left are the problem's. Borrows the view and the workspace
 * (aligned for any type). Returns QS_OK; QS_E_ARGUMENT; QS_E_WORKSPACE;
 * QS_E_UNSUPPORTED (the file does not say what its variables mean);
 * QS_E_ENCODING (a cut: the same problem in another encoding has a model);
 * QS_E_CORRUPT (the couplings are not what the encoding says); QS_E_OVERFLOW (a
 * cost beyond 2^31 - 1, or the model's own limit: the largest V times the sum
 * of all weights, and 2^31 - 1 for each site, come to more than
 * 2^QS_MODEL_BITS. So no sum of costs leaves an int64_t, whatever the labels).
 */
QS_MUST_CHECK qs_status qs_model_build(const qs_index *index, void *workspace,
                                       size_t workspace_size, qs_model *model);

/* V(a, b), without a weight. */
int64_t qs_model_pairwise(const qs_model *model, uint32_t a, uint32_t b);

/* F of a labelling of the model's sites (labels in range). */
int64_t qs_model_energy(const qs_model *model, const uint16_t *labelling);

/* Winner takes all: each site's cheapest label, the lowest one of equals. */
void qs_model_winner(const qs_model *model, uint16_t *labelling);

/* The labelling of the problem's sites: that of the model's, less the masked
 * cells. In place if `out` is `labelling`. */
void qs_model_sites(const qs_model *model, const uint16_t *labelling,
                    uint16_t *out);

#ifdef __cplusplus
}
#endif

#endif
