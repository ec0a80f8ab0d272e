/* The labelling problem: sites, labels, unary and pairwise costs, and its
 * energy
 *
 *     F(w) = sum_p theta_p(w_p) + sum_{pq in N} weight_pq V(w_p, w_q)
 *
 * (Heidari, Dinneen and Delmas, eq. (3), where V is Potts and every weight is
 * lambda). All costs are integers, in units of 1/scale: with lambda = 12.5 take
 * scale 2, weight 25 and theta doubled. */
#ifndef QSTEREO_PROBLEM_H
#define QSTEREO_PROBLEM_H

#include "limits.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* V(a, b) of two labels (indices 0 .. labels - 1). Tables: V(a, b) = table[a *
 * labels + b], a being the label of the edge's first site: the left or upper
 * one in a grid. */
typedef enum qs_smoothness {
    QS_POTTS = 0, /* a != b */
    QS_TRUNCATED_LINEAR = 1, /* min(|a - b|, truncation) */
    QS_TRUNCATED_QUADRATIC = 2, /* min((a - b)^2, truncation) */
    QS_TABLE = 3
} qs_smoothness;

typedef struct qs_pairwise {
    qs_smoothness smoothness;
    uint32_t truncation; /* of the linear and quadratic V; 0 = none */
    const int32_t
        *table; /* labels x labels, no entry negative; QS_TABLE only */
} qs_pairwise;

/* A 4-neighbour grid of width x height cells. Sites are its cells in raster
 * order, masked ones left out. */
typedef struct qs_grid {
    uint32_t width, height;
    const uint8_t *mask; /* width * height bytes, 0 = the cell is no site; NULL
                            = every cell is one */
    const int32_t *right; /* weight of the edge from each cell to its right
                             neighbour, width * height (last column unused) */
    const int32_t *down; /* and to its lower neighbour (last row unused); both
                            or neither: NULL = every weight is `weight` */
} qs_grid;

/* An edge of a problem that is no grid. */
typedef struct qs_edge {
    uint32_t first, second; /* sites, first < second */
    int32_t weight; /* at least 0 */
} qs_edge;

/* Computes the unary costs of one row of an unmasked or masked grid (all
 * cells), each site's less its least cost.
 *
 * context  the source's own
 * row      0 .. height - 1
 * costs    out: width x labels, label by label within each cell; uint8_t or
 * uint32_t as the source's `bytes` says least    out: width; the least cost of
 * each cell, which has been subtracted from all of its labels */
typedef void qs_cost_row(void *context, uint32_t row, void *costs,
                         int32_t *least);

/* Unary costs made on the way, so that no more than one row of them is ever in
 * memory (grids only). */
typedef struct qs_cost_source {
    qs_cost_row *row;
    void *context;
    unsigned bytes; /* of each cost that `row` writes: 1 or 4 */
} qs_cost_source;

/* Where the sites stand in a picture: a window whose cell (0, 0) is the
 * picture's pixel (x, y). */
typedef struct qs_frame {
    uint32_t picture_width, picture_height;
    uint32_t x, y;
    uint32_t first; /* at most 2^31 - 1; label j stands for the value (disparity
                       in pixels) first + j */
} qs_frame;

/* A problem borrows all that it points to. Either grid.width > 0, or edges
 * (with `sites` given). */
typedef struct qs_problem {
    uint32_t sites; /* of an edge list; of a grid it is computed: see
                       qs_problem_sites */
    uint32_t labels; /* 1 .. QS_LABELS_MAX */
    uint32_t scale; /* integer units in one real unit, at least 1 */
    int32_t weight; /* of every edge of a grid that has no weights of its own:
                       lambda * scale, at least 0 */
    qs_pairwise pairwise;
    qs_grid grid; /* width 0 = no grid */
    const qs_edge *edges;
    size_t edge_count;
    const int32_t *costs; /* sites x labels; or NULL, and */
    qs_cost_source source; /* the maker of a grid's costs */
    qs_frame frame; /* zero = the grid is the picture and labels stand for 0, 1,
                       ... */
} qs_problem;

/* Checks all that the comments above demand.
 * Returns QS_OK, QS_E_ARGUMENT, or QS_E_LIMIT (more than QS_VARIABLES_MAX sites
 * x labels, or 2^31 - 1 edges). */
QS_MUST_CHECK qs_status qs_problem_check(const qs_problem *problem);

/* The number of sites: of a grid its unmasked cells, else `sites`. */
uint32_t qs_problem_sites(const qs_problem *problem);

/* V(a, b) of two labels, without the edge's weight. */
int64_t qs_pairwise_cost(const qs_problem *problem, uint32_t a, uint32_t b);

/* Bytes of workspace that qs_problem_energy needs: one row of costs where the
 * problem makes them on the way, else 0. */
size_t qs_problem_workspace(const qs_problem *problem);

/* F of a labelling, in integer units.
 *
 * labelling  a label index of every site
 * Returns QS_OK, QS_E_ARGUMENT (as qs_problem_check, or a label out of range),
 * QS_E_LIMIT, QS_E_WORKSPACE, or QS_E_OVERFLOW. */
QS_MUST_CHECK qs_status qs_problem_energy(const qs_problem *problem,
                                          const uint16_t *labelling,
                                          void *workspace,
                                          size_t workspace_size,
                                          int64_t *energy);

#ifdef __cplusplus
}
#endif

#endif
