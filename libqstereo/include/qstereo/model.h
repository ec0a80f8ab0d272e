/* A labelling problem laid out for the solvers: all costs in one array, and the
 * edges either as those of a full grid or as lists of neighbours.
 *
 *     F(w) = constant + sum_p unary_p(w_p) + sum_{pq} weight_pq V(w_p, w_q)
 *
 * The sites of a model are those of the problem. Only of a masked grid all
 * cells are sites of the model, so that every grid is a full one; the masked
 * ones have no costs and no edges. */
#ifndef QSTEREO_MODEL_H
#define QSTEREO_MODEL_H

#include "qubo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An edge as one of its two sites sees it. */
typedef struct qs_link {
    uint32_t site; /* the other one */
    uint32_t edge; /* the number of the edge, 0 .. edges - 1 */
    int32_t weight; /* at least 0 */
} qs_link;

/* Its fields are for reading. The arrays are in the workspace that it was made
 * in. */
typedef struct qs_model {
    uint32_t sites, labels;
    int64_t constant;
    const int32_t *unary; /* sites x labels; the least of each site is 0 */
    /* sites x labels: 0 = this label is not left to this site; its unary cost
     * is then above all that the site's edges can cost. NULL = all are left. */
    const uint8_t *kept;
    qs_pairwise pairwise; /* V(a, b) with a the label of the lower-numbered
                             site; the table as in qs_problem */
    int64_t pairwise_max; /* the largest V of all edges */
    /* QS_TABLES only; else NULL. Edges are numbered as qs_model_edge_pairwise
     * says. */
    const int32_t *tables; /* labels x labels each */
    const uint32_t *table_of; /* edges: the number of each one's table */
    const int32_t *table_max; /* tables: the largest entry of each */
    /* A grid: site (x, y) is y * width + x. Width 0 = no grid. */
    uint32_t width, height;
    const int32_t *right; /* sites: weight of the edge to the right neighbour, 0
                             in the last column */
    const int32_t *down; /* sites: to the lower neighbour, 0 in the last row */
    const uint8_t *mask; /* of a masked grid: a bit for each cell as in
                            qs_labels; else NULL */
    /* Any other graph: */
    uint32_t edges;
    const uint32_t *link_start; /* sites + 1: where each site's links begin */
    const qs_link *links; /* 2 x edges; those of a site are sorted by the other
                             site */
} qs_model;

enum { QS_MODEL_BITS = 60 };

/* Bytes of workspace for qs_model_of_problem. The problem is one that
 * qs_problem_check accepts. */
size_t qs_model_of_problem_workspace(const qs_problem *problem);

/* The model of a problem in memory: what qs_model_build makes of its file, but
 * without a file. Every kind of problem has one.
 *
 * problem    read once, row by row where it makes its costs on the way; of it
 *            only tables of pairwise costs stay borrowed
 * workspace  aligned for any type; the model stays in it
 * model      out
 * labels     out, may be NULL: what the file of the problem says in its side
 *            chunk labl, with encoding one-hot and penalty local: the picture,
 *            the mask (in the workspace), the scale. For qs_recode and
 *            qs_map_of_labelling
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, a problem that qs_problem_check refuses, or
 *                  a table that was made has an entry below 0
 *   QS_E_LIMIT     as qs_problem_check
 *   QS_E_WORKSPACE
 *   QS_E_OVERFLOW  a unary cost, less the least of its site, or a pairwise cost
 *                  is above 2^31 - 1, or the sums leave QS_MODEL_BITS: see
 *                  qs_model_build */
QS_MUST_CHECK qs_status qs_model_of_problem(const qs_problem *problem,
                                            void *workspace,
                                            size_t workspace_size,
                                            qs_model *model, qs_labels *labels);

/* What a problem without masked cells says of its labels, for those who need no
 * model.
 *
 * Returns QS_OK, what qs_problem_check returns, or QS_E_ARGUMENT: a null
 * pointer, or a mask */
QS_MUST_CHECK qs_status qs_labels_of_problem(const qs_problem *problem,
                                             qs_labels *labels);

/* Bytes of workspace for qs_model_build. */
size_t qs_model_workspace(const qs_qubo *qubo);

/* The model of a .qcf with the encoding one-hot, one-hot-sparse or domain-wall.
 * It is made from the file alone, so that every solver answers exactly the
 * problem that an annealer is given.
 *
 * A file may have fixed sites and left out labels. The model still has the
 * sites and labels of the whole problem:
 *   - A fixed site has its label at cost 0, and no edges.
 *   - A label that is left out costs one more than all edges of its site can,
 *     at most 2^31 - 1. No solver returns such a label.
 *   - Edges that the file has folded into other terms have weight 0. So the
 *     energies of labellings of the labels left are those of F, of others not.
 *   - What truncating the costs took away is added again.
 *
 * index      borrowed by the model, with its view
 * workspace  aligned for any type; the model stays in it
 * model      out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT     a null pointer
 *   QS_E_WORKSPACE
 *   QS_E_UNSUPPORTED  the file does not say what its variables mean
 *   QS_E_ENCODING     a cut: the same problem in another encoding has a model
 *   QS_E_CORRUPT      the couplings are not what the encoding says
 *   QS_E_OVERFLOW     a cost is above 2^31 - 1; or the largest V times the sum
 *                     of all weights, and 2^31 - 1 for each site, come to more
 *                     than 2^QS_MODEL_BITS. Below that no sum of costs leaves
 *                     an int64_t, whatever the labels */
QS_MUST_CHECK qs_status qs_model_build(const qs_index *index, void *workspace,
                                       size_t workspace_size, qs_model *model);

/* V(a, b), without a weight. Not of QS_TABLES. */
int64_t qs_model_pairwise(const qs_model *model, uint32_t a, uint32_t b);

/* V(a, b) of an edge, without its weight; a is the label of the lower-numbered
 * site.
 *
 * edge  of a grid: 2 * p for the edge from site p to the right, 2 * p + 1 for
 *       the one down. Of any other graph: as in qs_link */
int64_t qs_model_edge_pairwise(const qs_model *model, uint32_t edge, uint32_t a,
                               uint32_t b);

/* F of a labelling of the model's sites. All labels are in range. */
int64_t qs_model_energy(const qs_model *model, const uint16_t *labelling);

/* Winner takes all: gives each site its cheapest label, of equals the lowest.
 *
 * labelling  out: the model's sites */
void qs_model_winner(const qs_model *model, uint16_t *labelling);

/* From a labelling of the model's sites to one of the problem's: without the
 * masked cells.
 *
 * out  may be `labelling` */
void qs_model_sites(const qs_model *model, const uint16_t *labelling,
                    uint16_t *out);

#ifdef __cplusplus
}
#endif

#endif
