/* The labelling problem: sites, labels, and what a labelling costs,
 *
 *     F(w) = sum_p theta_p(w_p) + sum_{pq in N} weight_pq V_pq(w_p, w_q).
 *
 * (Heidari, Dinneen and Delmas, eq. (3), where V is Potts and every weight is
 * lambda.) theta are the unary costs, V is the pairwise cost, mostly the same
 * for every edge. All are integers, in units of 1 / scale: for lambda = 12.5
 * take scale 2, weight 25, and theta doubled. */
#ifndef QSTEREO_PROBLEM_H
#define QSTEREO_PROBLEM_H

#include "limits.h"
#include "meaning.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The pairwise cost V(a, b) of two labels, which are 0 .. labels - 1. */
typedef enum qs_smoothness {
    QS_POTTS = 0, /* 0 if a = b, else 1 */
    QS_TRUNCATED_LINEAR = 1, /* min(|a - b|, truncation) */
    QS_TRUNCATED_QUADRATIC = 2, /* min((a - b)^2, truncation) */
    QS_TABLE = 3, /* table[a * labels + b]; a is the label of the edge's first
                     site: the left or the upper one in a grid */
    QS_TABLES = 4 /* the same with a table of its own for each edge: see
                     qs_problem.tables and .table_source */
} qs_smoothness;

typedef struct qs_pairwise {
    qs_smoothness smoothness;
    uint32_t truncation; /* of the linear and the quadratic V; 0 = none */
    const int32_t *table; /* QS_TABLE only: labels x labels, none below 0 */
} qs_pairwise;

/* A grid of width x height cells. Its sites are its cells, row after row,
 * without the masked ones. Each site has an edge to each of its up to 4
 * neighbours. */
typedef struct qs_grid {
    uint32_t width, height;
    /* width x height bytes, 0 = the cell is not a site. NULL = all are. */
    const uint8_t *mask;
    /* width x height weights of the edges from each cell to its right
     * neighbour (the last column is not used), and to its lower neighbour (the
     * last row is not used). Both or neither; NULL = every weight is
     * qs_problem.weight. */
    const int32_t *right, *down;
} qs_grid;

/* An edge of a problem that is not a grid. */
typedef struct qs_edge {
    uint32_t first, second; /* sites, first < second */
    int32_t weight; /* at least 0 */
} qs_edge;

/* Computes the unary costs of a row of a grid: of all its cells, masked ones
 * too. From the costs of each cell their least is subtracted.
 *
 * context  as in qs_cost_source
 * row      0 .. height - 1
 * costs    out: width x labels, the labels of a cell together; uint8_t or
 *          uint32_t, as qs_cost_source.bytes says
 * least    out: width; what has been subtracted at each cell */
typedef void qs_cost_row(void *context, uint32_t row, void *costs,
                         int32_t *least);

/* Computes the unary cost of one label for each cell of a row, masked ones too:
 * what qs_cost_row writes for that label and has subtracted, together.
 *
 * labels  of each of the width cells; all below the problem's
 * costs   out: width */
typedef void qs_cost_pick(void *context, uint32_t row, const uint16_t *labels,
                          int32_t *costs);

/* Unary costs of a grid that are made when they are needed, so that no more
 * than one row of them is in memory. */
typedef struct qs_cost_source {
    qs_cost_row *row;
    void *context; /* of row and pick */
    uint8_t bytes; /* of a cost that `row` writes: 1 or 4 */
    /* Rows may be made at the same time, each with a copy of the context of its
     * own. 0 or 1 = there is only one */
    uint8_t copies;
    uint16_t stride; /* bytes from a copy to the next */
    qs_cost_pick *pick; /* NULL = none; it makes energies quicker to compute */
} qs_cost_source;

/* Computes the tables of the edges that begin in a row of a grid: V of the
 * label a of the left or upper cell and b of the other one is at
 * [a * labels + b] of the edge's table. None is below 0. Edges of masked cells
 * are written too; nobody looks at them. The edges' weights are multiplied with
 * the tables.
 *
 * context  as in qs_table_source
 * row      0 .. height - 1
 * right    out: (width - 1) x labels x labels, from each cell to its right
 *          neighbour. NULL = not wanted
 * down     out: width x labels x labels, from each cell to its lower neighbour.
 *          NULL = not wanted; so it is in the last row */
typedef void qs_table_row(void *context, uint32_t row, int32_t *right,
                          int32_t *down);

/* Tables of the edges of a grid that are made when they are needed, so that no
 * more than one row of them is in memory. They are made several times, always
 * the same. */
typedef struct qs_table_source {
    qs_table_row *row;
    void *context; /* of row */
} qs_table_source;

/* Where the sites stand in a picture: in a window whose cell (0, 0) is pixel
 * (x, y) of the picture. */
typedef struct qs_frame {
    uint32_t picture_width, picture_height;
    uint32_t x, y;
    int32_t first; /* label j stands for the value (a disparity in pixels)
                      first + j; above -2^31, and below 0 for disparities
                      alone */
} qs_frame;

/* A problem borrows all that it points to. It is a grid (grid.width > 0) or a
 * list of edges (grid.width = 0). */
typedef struct qs_problem {
    uint32_t sites; /* of a list of edges. Of a grid: see qs_problem_sites */
    uint32_t labels; /* 1 .. QS_LABELS_MAX */
    uint32_t scale; /* integer units in one real unit, at least 1 */
    int32_t weight; /* of every edge of a grid without weights of its own:
                       lambda * scale, at least 0 */
    qs_pairwise pairwise;
    qs_grid grid;
    const qs_edge *edges;
    size_t edge_count;
    /* QS_TABLES only. Lists of edges: edge_count x labels x labels, none below
     * 0. Grids have the source. */
    const int32_t *tables;
    qs_table_source table_source;
    const int32_t *costs; /* sites x labels; NULL = `source` makes them */
    qs_cost_source source; /* grids only */
    /* sites x labels bytes: 0 = this label is forbidden at this site. Each site
     * has a label that is not. Whatever a forbidden label costs, it is never
     * taken. So a site can have fewer labels than others. NULL = every label is
     * allowed at every site. */
    const uint8_t *allowed;
    qs_frame frame; /* zero = the grid is the picture, and labels stand for 0,
                       1, ... */
    qs_meaning meaning; /* of the labels; zero = disparities */
} qs_problem;

/* Checks all that the comments above demand, but for the tables that a
 * table_source makes: who uses them checks them.
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  something is not as they say
 *   QS_E_LIMIT     sites x labels, or edges, are more than QS_VARIABLES_MAX */
QS_MUST_CHECK qs_status qs_problem_check(const qs_problem *problem);

/* The number of sites: of a grid the cells that are not masked. */
uint32_t qs_problem_sites(const qs_problem *problem);

/* V(a, b), without the weight of an edge. Not of QS_TABLES. */
int64_t qs_pairwise_cost(const qs_problem *problem, uint32_t a, uint32_t b);

/* Bytes of workspace for qs_problem_energy: a row of costs and a row of tables
 * if the problem makes them when they are needed, else 0. */
size_t qs_problem_workspace(const qs_problem *problem);

/* F of a labelling, in integer units.
 *
 * labelling  the label of each site
 * workspace  aligned for any type
 * energy     out
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, a problem that qs_problem_check refuses, a
 *                  label that there is not or that is forbidden, or a table
 *                  that was made has an entry below 0 for these labels
 *   QS_E_LIMIT     as qs_problem_check
 *   QS_E_WORKSPACE
 *   QS_E_OVERFLOW  the energy, or a part of it, is beyond QS_ENERGY_MAX */
QS_MUST_CHECK qs_status qs_problem_energy(const qs_problem *problem,
                                          const uint16_t *labelling,
                                          void *workspace,
                                          size_t workspace_size,
                                          int64_t *energy);

#ifdef __cplusplus
}
#endif

#endif
