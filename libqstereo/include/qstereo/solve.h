/* The classical solvers. They take a model (model.h). Every energy is exact,
 * every bound is a proof. The same arguments give the same answer on every
 * machine. */
#ifndef QSTEREO_SOLVE_H
#define QSTEREO_SOLVE_H

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How far a solver is. */
typedef struct qs_progress {
    int64_t energy; /* of the best labelling so far; with anneal of the present
                       one */
    int64_t lower_bound; /* of all labellings; QS_NO_BOUND if the solver has
                            none */
    uint64_t iteration;
} qs_progress;

/* Called with the progress of a solver. Returns false to stop it as soon as
 * possible. */
typedef bool qs_watch(void *context, const qs_progress *progress);

enum { QS_ALL_TIME = 1 << 16 };

/* Takes down what proves a bound: certificate.h has one that writes a file.
 * trws and min_cut call it at their end, best too where it passes messages or
 * cuts, reduce whenever labels may leave. Other solvers do not. `context` is
 * its own. */
typedef struct qs_witness {
    /* A split of the costs among chains begins.
     *
     * model      the problem as the solver has it at this moment: labels may
     *            have left, and edges of sites with one label may have become
     *            costs of their neighbours
     * shift      costs are multiplied by 2^shift
     * labelling  the best one known, of labels left */
    void (*split)(void *context, const qs_model *model, unsigned shift,
                  const uint16_t *labelling);
    /* The share of a chain in the costs of a site. Chain 0 of a grid is the
     * site's row, chain 1 its column. Chain i of a graph has the site's i-th
     * edge to an earlier site, and its i-th to a later one, of weight above 0.
     * Sites without such edges are left out.
     *
     * share  of each label: whole numbers of `bytes` bytes, 4 or 8 */
    void (*share)(void *context, const qs_model *model, uint32_t site,
                  uint32_t chain, const void *share, unsigned bytes);
    /* The split is complete, or there was none.
     *
     * kept  sites x labels: those that are left now; NULL = all. What has left
     *       is ruled out by the marginals of the split, or where there was
     *       none since the last call, by Goldstein's criterion */
    void (*end)(void *context, const uint8_t *kept);
    /* May a part be solved exactly? It is all that edges join, or several such
     * parts, and the last `end` has told its labels. If so, the witness has
     * solved it by itself, and needs to hear no more of it.
     *
     * sites   of the part, count of them
     * labels  which of them are in an optimum has to be proven as well, and not
     *         its least energy alone
     *
     * Returns false if the part is too wide for the witness. Then it stays as
     * it is */
    bool (*part)(void *context, const uint32_t *sites, uint32_t count,
                 bool labels);
    void *context;
} qs_witness;

/* Does a part of a work, 0 .. parts - 1. */
typedef void qs_part(void *work, uint32_t part);

/* Does all parts of a work and returns when they are done. Any thread may do
 * any part, in any order.
 *
 * helpers  the caller's own */
typedef void qs_together(void *helpers, qs_part *part, void *work,
                         uint32_t parts);

/* All zero = the defaults. */
typedef struct qs_solve_options {
    uint64_t iterations; /* at most; 0 = the solver's own default, which its
                            comment states */
    uint64_t seed; /* of the solvers that draw random numbers */
    /* NULL = nobody. It is called after each iteration and each move, and
     * within these about once in 2^20 numbers that are computed, which take
     * about a millisecond. So a solver that it stops ends soon. The solution is
     * then the best so far, or the winner's labelling and the bound that needs
     * no iteration. */
    qs_watch *watch;
    void *context; /* of watch and spent */
    /* The library has no clock. For anneal: how much of the time that it has is
     * over, 0 to QS_ALL_TIME. NULL = it has all the time that its iterations
     * take */
    uint32_t (*spent)(void *context);
    const uint16_t *start; /* labels of the model's sites that best begins with:
                              its answer is not above them. NULL = none. Other
                              solvers do not look at it */
    const qs_witness *witness; /* NULL = nobody. With one, the watch is called
                                  between iterations of messages alone. trws,
                                  best and min_cut call it, where best packs
                                  it goes on for the witness */
    /* The library has no threads. trws16 hands out what can be done at the same
     * time; other solvers do not. The answer is the same, and the watch is
     * called by the thread that called the solver. NULL = that thread does it
     * all */
    qs_together *together;
    void *helpers; /* of together */
    uint32_t workers; /* how many parts `together` does at the same time */
} qs_solve_options;

typedef struct qs_solution {
    int64_t energy; /* of the labelling */
    int64_t lower_bound; /* of all labellings; QS_NO_BOUND if the solver has
                            none. Equal to the energy = proven optimal */
    uint64_t iterations; /* that were done */
    bool converged; /* the solver came to its end by itself: no watch stopped
                       it, nor a limit of iterations */
} qs_solution;

/* Every solver:
 *
 * options    NULL = all zero
 * workspace  at least the solver's ..._workspace(model) bytes, aligned for any
 *            type
 * labelling  out: a label of each of the model's sites, the best found. For
 *            icm, anneal, expansion and swap it is also the start;
 *            qs_model_winner makes a usual one. When the watch is called it
 *            holds the labelling that has the energy told. In the end every
 *            label is one that is left to its site (model->kept), also if the
 *            solver was stopped
 * solution   out
 *
 * Returns
 *   QS_OK          also when stopped
 *   QS_E_ARGUMENT  a null pointer, or a start with a label that there is not
 *   QS_E_WORKSPACE
 *   QS_E_ENCODING  the solver cannot be used with this pairwise cost
 *   QS_E_OVERFLOW  qs_min_cut only: the costs are too large for its arithmetic
 *
 * Solvers compute in 32 bits, and where costs are too large for that, in 64. So
 * there are no costs that a model may have and a solver not, but the large ones
 * take about twice the memory and up to four times the time. */
typedef qs_status qs_solver(const qs_model *model,
                            const qs_solve_options *options, void *workspace,
                            size_t workspace_size, uint16_t *labelling,
                            qs_solution *solution);

/* Iterated conditional modes (Besag 1986): each site in turn takes its cheapest
 * label, given the labels of its neighbours, of equals the lowest; until none
 * changes. An iteration is a sweep over all sites; default: no limit. */
QS_MUST_CHECK qs_status qs_icm(const qs_model *model,
                               const qs_solve_options *options, void *workspace,
                               size_t workspace_size, uint16_t *labelling,
                               qs_solution *solution);
size_t qs_icm_workspace(const qs_model *model);

/* Simulated annealing on labels (Cerny 1985; Metropolis et al. 1953): each site
 * in turn is offered a label drawn from all. The temperature falls in equal
 * ratios from half the largest cost of an edge to an eighth of that; then icm.
 * The result is never above the start. An iteration is a sweep; default 1000.
 * Where options->spent is there, the temperature follows the time that is over,
 * and there is no limit of iterations unless one is asked for. */
QS_MUST_CHECK qs_status qs_anneal(const qs_model *model,
                                  const qs_solve_options *options,
                                  void *workspace, size_t workspace_size,
                                  uint16_t *labelling, qs_solution *solution);
size_t qs_anneal_workspace(const qs_model *model);

/* Alpha-expansion (Boykov, Veksler and Zabih 2001). For each label in turn it
 * makes the best move in which any sites may change to that label; a minimum
 * cut finds it. It ends when no move lowers the energy. If the pairwise cost is
 * not a metric, terms of a move are lowered as far as a cut needs (Rother,
 * Kumar, Kolmogorov and Blake 2005). Then the move is not always the best one,
 * but it never raises the energy. An iteration is a cycle over the labels;
 * default: no limit. */
QS_MUST_CHECK qs_status qs_expansion(const qs_model *model,
                                     const qs_solve_options *options,
                                     void *workspace, size_t workspace_size,
                                     uint16_t *labelling,
                                     qs_solution *solution);
size_t qs_expansion_workspace(const qs_model *model);

/* Alpha-beta-swap (the same paper): like expansion, with moves in which each
 * site of two labels may change to the other one. Terms are lowered if the
 * pairwise cost is not a semi-metric (V(a, b) = V(b, a), V(a, a) = 0). An
 * iteration is a cycle over the pairs of labels; default: no limit. */
QS_MUST_CHECK qs_status qs_swap(const qs_model *model,
                                const qs_solve_options *options,
                                void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution);
size_t qs_swap_workspace(const qs_model *model);

/* Max-product loopy belief propagation with a sequential schedule: BP-M of the
 * Middlebury study (Szeliski et al. 2008; Tappen and Freeman 2003). The study's
 * code keeps 1/5 of an old message, this keeps 3/16. The labelling is made site
 * by site, each with the labels of the sites before it, so that ties cost
 * nothing; the best one of all iterations is kept. An iteration is four sweeps,
 * right, left, down and up (of a general graph two: in the order of the sites,
 * and back); default 50. */
QS_MUST_CHECK qs_status qs_bp(const qs_model *model,
                              const qs_solve_options *options, void *workspace,
                              size_t workspace_size, uint16_t *labelling,
                              qs_solution *solution);
size_t qs_bp_workspace(const qs_model *model);

/* Sequential tree-reweighted message passing, TRW-S (Kolmogorov 2006). Stops
 * when the bound proves the best labelling found. Messages are fixed-point
 * numbers, but the bound is exact: whatever the messages are, the costs that
 * they lead to are minimised in integers on each row and column of the grid (on
 * each chain of a general graph). An iteration is a forward and a backward
 * pass; default 500. */
QS_MUST_CHECK qs_status qs_trws(const qs_model *model,
                                const qs_solve_options *options,
                                void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution);
size_t qs_trws_workspace(const qs_model *model);

/* TRW-S as above with costs of one byte and messages of two, straight from a
 * problem: no model is needed, so the workspace is all the memory: about 5
 * bytes for each site and label, where labels count in whole sixteens, and
 * about 3 if one iteration is wanted. For grids without masked cells and
 * forbidden labels, with Potts or truncated linear costs. The labelling is made
 * once, after the last iteration; the bound is exact here, too. Default: 2
 * iterations.
 *
 * Returns also
 *   QS_E_ENCODING  the problem is none of these
 *   QS_E_LIMIT     as qs_problem_check
 *   QS_E_OVERFLOW  the costs of a site differ by more than 255 units, or
 *                  255 + 4 weight V exceeds 16383 on an edge
 *
 * The workspace is 0 if the problem is none of these.
 *
 * iterations  of the workspace: as in the options; 0 = default */
QS_MUST_CHECK qs_status qs_trws16(const qs_problem *problem,
                                  const qs_solve_options *options,
                                  void *workspace, size_t workspace_size,
                                  uint16_t *labelling, qs_solution *solution);
size_t qs_trws16_workspace(const qs_problem *problem, uint64_t iterations);

/* Makes a labelling better by labels near its own: each site keeps its label or
 * takes the one before or after. Row after row, and then column after column,
 * is solved exactly by dynamic programming while the lines beside it keep their
 * labels (block ICM; chains in turn). So the energy never rises. For grids
 * without masked cells and forbidden labels whose costs come from a source that
 * has `pick`, with Potts or truncated linear costs: only the costs of those
 * labels are computed. It has no bound. About 17 bytes a site. An iteration is
 * all rows and columns once; default 1.
 *
 * labelling  in: a label of each site; out: the better one
 *
 * Returns also
 *   QS_E_ENCODING  the problem is none of these
 *   QS_E_ARGUMENT  a label that there is not
 *
 * The workspace is 0 if the problem is none of these. */
QS_MUST_CHECK qs_status qs_near(const qs_problem *problem,
                                const qs_solve_options *options,
                                void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution);
size_t qs_near_workspace(const qs_problem *problem);

/* The optimum by minimum cuts. It is proven, unless a watch or a limit stops
 * the solver. V must be submodular, for all labels
 *
 *     V(a, b) + V(a + 1, b + 1) <= V(a + 1, b) + V(a, b + 1),
 *
 * else QS_E_ENCODING. These are submodular: linear and quadratic costs without
 * truncation (or with one that no two labels reach), Potts with two labels, and
 * many tables. Where each edge has its own, there must be two labels, and all
 * tables of edges with a weight be submodular. There are two ways:
 *
 * - If V(a, b) = g(a - b) and the unary costs are convex too: steepest descent
 *   by cuts (Murota 2003; Kolmogorov and Shioura 2009). It starts from the
 *   labelling and takes about 40 bytes a site. An iteration is a cut.
 * - Else one cut of a graph with a node for each site and label (Boykov and
 *   Jolly 2001 for two labels; Ishikawa 2003; Schlesinger and Flach 2006). On a
 *   grid with linear costs it takes about 50 bytes a node. If V couples many
 *   pairs of labels, as quadratic costs do, it takes 40 bytes for each of them
 *   and each edge. On grids with linear costs a few iterations of TRW-S come
 *   first and leave little flow to find. The cut is the only iteration. If the
 *   watch stops it, it returns the labelling of the messages (without messages,
 *   the labelling that it was given) and the bound that it has reached.
 *
 * The workspace is SIZE_MAX if that graph would have 2^32 nodes or arcs, and 0
 * if V is not submodular. QS_E_OVERFLOW: a cost, or what the edges of a site
 * can cost, times the number of labels, is 2^60 or more. */
QS_MUST_CHECK qs_status qs_min_cut(const qs_model *model,
                                   const qs_solve_options *options,
                                   void *workspace, size_t workspace_size,
                                   uint16_t *labelling, qs_solution *solution);
size_t qs_min_cut_workspace(const qs_model *model);

/* The optimum by branch and bound, proven unless a watch or a limit stops it,
 * of problems with two labels in which no edge favours the same label at both
 * ends:
 *
 *     V(0, 1) + V(1, 0) <= V(0, 0) + V(1, 1),
 *
 * as when boxes that overlap are chosen (overlap.h); else, and of tables of
 * their own for the edges, QS_E_ENCODING. It is quick where sites that share
 * an edge mostly exclude each other. Stopped, it returns the best labelling and
 * the bound so far. (Bounds by covers of cliques, as for largest cliques:
 * Tomita and Seki 2003.) An iteration is a labelling tried; default: no
 * limit. */
QS_MUST_CHECK qs_status qs_pack(const qs_model *model,
                                const qs_solve_options *options,
                                void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution);
size_t qs_pack_workspace(const qs_model *model);

/* The best of these together. It runs TRW-S. After iterations 8, 16, 32 and so
 * on, moves improve the labelling that TRW-S has reached: expansion, or, if the
 * pairwise cost is not a metric, jumps of all labels and moves to each label.
 * Meanwhile labels that are proven to be in no optimum leave the problem, parts
 * of it that are small enough are solved exactly, windows of a large grid are
 * solved with their neighbours held, and those where the gap sits are cut out
 * and searched, other problems are searched by moves on trees (Hamze and de
 * Freitas 2004) after kicks by chance, and where the bound stalls TRW-S begins
 * anew on what is left: all that qs_reduce (reduce.h) does. Of two labellings
 * the better parts are merged. It ends when the bound proves the best
 * labelling, or when half of all iterations, 512 or more, have gained nothing.
 * What a cut decides quickly is left to qs_min_cut: two labels, convex costs,
 * and linear costs on a grid. Where qs_pack can be used it goes first, with a
 * limit of its own. Works with every pairwise cost. An iteration is one of
 * TRW-S, or of qs_min_cut, or of qs_pack; default 2000.
 *
 * Returns QS_E_ARGUMENT also if options->start has a label that there is not */
QS_MUST_CHECK qs_status qs_best(const qs_model *model,
                                const qs_solve_options *options,
                                void *workspace, size_t workspace_size,
                                uint16_t *labelling, qs_solution *solution);
size_t qs_best_workspace(const qs_model *model);

#ifdef __cplusplus
}
#endif

#endif
