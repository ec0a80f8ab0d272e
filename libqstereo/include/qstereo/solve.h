/* The classical solvers. Each takes a model (model.h), the caller's workspace,
 * and a labelling of the model's sites; each energy is exact, each bound a
 * proof. They are deterministic: the same arguments give the same answer on
 * every machine. */
#ifndef QSTEREO_SOLVE_H
#define QSTEREO_SOLVE_H

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define QS_NO_BOUND INT64_MIN

/* How far a solver is. */
typedef struct qs_progress {
    int64_t
        energy; /* of the best labelling so far; of anneal the present one */
    int64_t lower_bound; /* of all labellings; QS_NO_BOUND where the solver has
                            none */
    uint64_t iteration;
} qs_progress;

/* Told of progress; returns false to stop the solver at the next opportunity.
 */
typedef bool qs_watch(void *context, const qs_progress *progress);

typedef struct qs_solve_options {
    uint64_t iterations; /* at most; 0 = the solver's own default, which its
                            comment states */
    uint64_t seed; /* of the solvers that draw numbers */
    qs_watch *watch; /* NULL = nobody; called at least once an iteration (of
                        which there may be none, as in swap with one label) */
    void *context; /* of watch */
} qs_solve_options;

typedef struct qs_solution {
    int64_t energy; /* of the labelling */
    int64_t lower_bound; /* QS_NO_BOUND where the solver has none; proven
                            optimal if it equals the energy */
    uint64_t iterations; /* done */
    bool converged; /* it came to its end, not to a watch's word or, where it
                       would have gone on, to its limit of iterations */
} qs_solution;

/* Every solver:
 *
 * options    NULL = all zero
 * workspace  at least the solver's ..._workspace(model), aligned for any type
 * labelling  out: a label of each of the model's sites, the best found
 * (whenever the watch is called it holds that of the energy that the watch is
 * told); for icm, anneal, expansion and swap it is also the start
 * (qs_model_winner makes a usual one). Every label that is returned is left to
 * its site (model->kept), also by a solver that was stopped Returns QS_OK (also
 * when stopped), QS_E_ARGUMENT, QS_E_WORKSPACE, or QS_E_ENCODING: not usable
 * for this pairwise cost (QS_E_OVERFLOW: costs too large for the solver's
 * arithmetic). */
typedef qs_status qs_solver(const qs_model *model,
                            const qs_solve_options *options, void *workspace,
                            size_t workspace_size, uint16_t *labelling,
                            qs_solution *solution);

/* Iterated conditional modes (Besag 1986): each site in raster order takes its
 * cheapest label beside its neighbours, of equals the lowest, until none
 * changes. An iteration is a sweep; default: no limit. */
QS_MUST_CHECK qs_status qs_icm(const qs_model *, const qs_solve_options *,
                               void *, size_t, uint16_t *, qs_solution *);
size_t qs_icm_workspace(const qs_model *model);

/* Simulated annealing on labels (Cerny 1985; Metropolis): each site in raster
 * order is offered a label drawn from all, so that the search never leaves the
 * labellings. Geometric schedule from half the largest cost of an edge to an
 * eighth of that, then icm; never above the start. An iteration is a sweep;
 * default 1000. */
QS_MUST_CHECK qs_status qs_anneal(const qs_model *, const qs_solve_options *,
                                  void *, size_t, uint16_t *, qs_solution *);
size_t qs_anneal_workspace(const qs_model *model);

/* Alpha-expansion (Boykov, Veksler and Zabih 2001): the best move to each label
 * in turn by a minimum cut, until a cycle changes nothing. Where the pairwise
 * cost is no metric, terms of the moves are cut down as far as a cut needs
 * (Rother, Kumar, Kolmogorov and Blake 2005): a move is then not always the
 * best one, but never a rise. An iteration is a cycle over the labels; default:
 * no limit. */
QS_MUST_CHECK qs_status qs_expansion(const qs_model *, const qs_solve_options *,
                                     void *, size_t, uint16_t *, qs_solution *);
size_t qs_expansion_workspace(const qs_model *model);

/* Alpha-beta-swap (the same). Terms are cut down where the pairwise cost is no
 * semi-metric (V(a, b) = V(b, a), V(a, a) = 0). An iteration is a cycle over
 * the pairs of labels; default: no limit. */
QS_MUST_CHECK qs_status qs_swap(const qs_model *, const qs_solve_options *,
                                void *, size_t, uint16_t *, qs_solution *);
size_t qs_swap_workspace(const qs_model *model);

/* Max-product loopy belief propagation with sequential schedule, BP-M of the
 * Middlebury study (Szeliski et al. 2008; Tappen and Freeman 2003): an
 * iteration is the four sweeps right, left, down, up (a general graph: one
 * sweep in the order of the sites and one back). As the study's code keeps 1/5
 * of an old message, ours keeps 3/16. The labelling is decoded site by site,
 * not by the beliefs alone, so that ties cost nothing. Default 50. The best
 * labelling of all iterations is kept. */
QS_MUST_CHECK qs_status qs_bp(const qs_model *, const qs_solve_options *,
                              void *, size_t, uint16_t *, qs_solution *);
size_t qs_bp_workspace(const qs_model *model);

/* Sequential tree-reweighted message passing (Kolmogorov 2006). An iteration is
 * a forward and a backward pass; default 500. Stops when the bound proves the
 * best labelling found. The bound is exact: messages are fixed-point numbers,
 * whatever they are their reparametrisation is minimised in integers on each
 * row and column of the grid (on each chain of a general graph). */
QS_MUST_CHECK qs_status qs_trws(const qs_model *, const qs_solve_options *,
                                void *, size_t, uint16_t *, qs_solution *);
size_t qs_trws_workspace(const qs_model *model);

/* The optimum by minimum cuts, always proven unless a watch or a limit stops it,
 * for costs that cuts solve. Else QS_E_ENCODING. V must be submodular:
 *
 *     V(a, b) + V(a + 1, b + 1) <= V(a + 1, b) + V(a, b + 1)
 *
 * for all labels. Potts is with two labels, linear and quadratic are where they
 * are not truncated (or beyond the labels), and so are many tables. Then
 *
 * - where V(a, b) = g(a - b) and the unary costs are convex too: steepest
 *   descent by cuts (Murota 2003; Kolmogorov and Shioura 2009). It starts from
 *   the labelling; about 40 bytes a site. An iteration is a cut.
 * - else one cut of a graph with a node for each site and label (Boykov and
 *   Jolly 2001 for two labels; Ishikawa 2003; Schlesinger and Flach 2006). On a
 *   grid with linear costs about 50 bytes a node; where V couples many pairs of
 *   labels, as quadratic costs do, 40 bytes for each of them and each edge. On
 *   grids with linear costs messages go before the flow (a few iterations of
 *   TRW-S), which leave little for it to do. Its one iteration is the cut;
 *   stopped, it returns the messages' labelling or, without them, that which
 *   it was given, and the bound that it has reached.
 *
 * The workspace is SIZE_MAX where that graph would have 2^32 nodes or arcs; 0
 * where V is not submodular. QS_E_OVERFLOW: a cost, or what the edges of a site
 * can cost, times the number of labels, comes to 2^28 or more (of the descent,
 * without the number of labels). */
QS_MUST_CHECK qs_status qs_min_cut(const qs_model *, const qs_solve_options *,
                                   void *, size_t, uint16_t *, qs_solution *);
size_t qs_min_cut_workspace(const qs_model *model);

/* The best of these together: TRW-S, whose labelling is improved by expansion
 * after 8 iterations, 16, 32 and so on (where the pairwise cost is no metric, by
 * jumps of the labels and moves to each), until the bound proves the best labelling or it is stopped. TRW-S
 * comes first because in any given time it gets lower than expansion from the
 * winner's labelling. What a cut decides quickly is left to qs_min_cut: two
 * labels, convex costs, and linear costs on a grid. An iteration is one of TRW-S; default 2000. Works for
 * every pairwise cost. */
QS_MUST_CHECK qs_status qs_best(const qs_model *, const qs_solve_options *,
                                void *, size_t, uint16_t *, qs_solution *);
size_t qs_best_workspace(const qs_model *model);

#ifdef __cplusplus
}
#endif

#endif
