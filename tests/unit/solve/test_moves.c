/* Expansion, swap and the minimum cuts under them, against all cuts and all moves of tiny problems,
 * and on larger ones against the plainest of flows. */
#include "tiny.h"

#include <stdlib.h>
#include <string.h>

#include "model/metric.h"
#include "solve/min_cut.h"

enum {
    ROUNDS = 1500,
    BITS = 20,
    SIDE = 70,
    MANY = SIDE * SIDE,
    MOST_EDGES = 2 * MANY,
    MOST_LABELS = 6
};

/* A model made by hand, larger than the tiny ones: several chunks of sites. */
typedef struct field {
    qs_model model;
    int32_t unary[MANY * MOST_LABELS], right[MANY], down[MANY], table[MOST_LABELS * MOST_LABELS];
    uint32_t start[MANY + 1];
    qs_link links[2 * MOST_EDGES];
} field;

static int32_t random_weight(uint64_t *state, uint32_t kind, int32_t weight)
{
    return kind == 0                    ? weight
           : tiny_random(state, 5) == 0 ? 0
                                        : (int32_t)tiny_random(state, 2 * (uint32_t)weight);
}

/* Any edge list: of each site to some of the next ones. */
static void field_links(field *f, uint64_t *state, int32_t weight)
{
    uint32_t sites = f->model.sites, at = 0, edges = 0;
    static uint32_t number[MANY][4];
    static int32_t weights[MANY][4];
    const uint32_t step[4] = {1, 7, 30, 100};
    for (uint32_t p = 0; p < sites; p++) {
        f->start[p] = at;
        for (int k = 3; k >= 0; k--) {
            if (p >= step[k] && weights[p - step[k]][k] >= 0) {
                f->links[at++] =
                    (qs_link){p - step[k], number[p - step[k]][k], weights[p - step[k]][k]};
            }
        }
        for (int k = 0; k < 4; k++) {
            weights[p][k] = p + step[k] < sites && tiny_random(state, 2) == 0
                                ? random_weight(state, 1, weight)
                                : -1;
            if (weights[p][k] >= 0) {
                number[p][k] = edges++;
                f->links[at++] = (qs_link){p + step[k], number[p][k], weights[p][k]};
            }
        }
    }
    f->start[sites] = at;
    f->model.edges = edges;
    f->model.link_start = f->start;
    f->model.links = f->links;
}

static void field_make(field *f, uint64_t *state, bool grid, qs_smoothness smoothness,
                       int32_t weight, uint32_t unary)
{
    uint32_t width = 1 + tiny_random(state, SIDE), height = 1 + tiny_random(state, SIDE),
             kind = tiny_random(state, 2);
    uint32_t sparse = tiny_random(state, 3) * 20;
    if (tiny_random(state, 2) == 0) { /* a strip */
        width = 1 + width % 5;
        height = 1 + tiny_random(state, MANY / width);
    }
    memset(f, 0, sizeof *f);
    f->model = (qs_model){.sites = width * height,
                          .labels = 1 + tiny_random(state, MOST_LABELS),
                          .constant = 1234,
                          .unary = f->unary,
                          .pairwise = {smoothness, 2, f->table}};
    for (uint32_t a = 0; a < f->model.labels; a++) {
        for (uint32_t b = 0; b < f->model.labels; b++) {
            f->table[a * f->model.labels + b] = a == b ? 0 : a % 2 == b % 2 ? 2 : 3;
        }
    }
    f->model.pairwise_max = smoothness == QS_POTTS ? 1 : smoothness == QS_TRUNCATED_LINEAR ? 2 : 3;
    for (uint32_t p = 0; p < f->model.sites; p++) {
        bool blank = sparse > 0 && tiny_random(state, sparse) != 0; /* then flows go far */
        for (uint32_t a = 0; a < f->model.labels; a++) {
            f->unary[p * f->model.labels + a] = blank ? 0 : (int32_t)tiny_random(state, unary);
        }
    }
    if (!grid) {
        field_links(f, state, weight);
        return;
    }
    f->model.width = width;
    f->model.height = height;
    f->model.right = f->right;
    f->model.down = f->down;
    for (uint32_t p = 0; p < f->model.sites; p++) {
        f->right[p] = p % width + 1 < width ? random_weight(state, kind, weight) : 0;
        f->down[p] = p + width < f->model.sites ? random_weight(state, kind, weight) : 0;
    }
}

/* A simple maximum flow. From each excess in turn, a search by breadth looks for the nearest want,
 * until there is none that it can reach. No later path enters the nodes that it reached last, so
 * there never will be one. */
typedef struct plain {
    uint32_t arcs, mark, count;
    uint32_t to[4 * MOST_EDGES], next[4 * MOST_EDGES], first[MANY], marked[MANY], by[MANY],
        queue[MANY];
    int64_t room[4 * MOST_EDGES], excess[MANY];
} plain;

static void plain_arc(plain *g, uint32_t p, uint32_t q, int64_t there)
{
    assert_true(g->arcs + 2 <= 4 * MOST_EDGES);
    for (int k = 0; k < 2; k++) {
        uint32_t a = g->arcs++, tail = k ? q : p;
        g->to[a] = k ? p : q;
        g->room[a] = k ? 0 : there;
        g->next[a] = g->first[tail];
        g->first[tail] = a;
    }
}

/* Marks all that p reaches, up to the first want; returns that or UINT32_MAX. */
static uint32_t plain_reach(plain *g, uint32_t p)
{
    g->count = 0;
    g->queue[g->count++] = p;
    g->marked[p] = g->mark;
    g->by[p] = UINT32_MAX;
    for (uint32_t i = 0; i < g->count; i++) {
        for (uint32_t a = g->first[g->queue[i]]; a != UINT32_MAX; a = g->next[a]) {
            uint32_t q = g->to[a];
            if (g->room[a] > 0 && g->marked[q] != g->mark) {
                g->marked[q] = g->mark;
                g->by[q] = a;
                g->queue[g->count++] = q;
                if (g->excess[q] < 0) {
                    return q;
                }
            }
        }
    }
    return UINT32_MAX;
}

static void plain_flow(plain *g, uint32_t nodes)
{
    for (uint32_t p = 0; p < nodes; p++) {
        while (g->excess[p] > 0) {
            g->mark++;
            uint32_t end = plain_reach(g, p);
            if (end == UINT32_MAX) {
                break;
            }
            int64_t most = g->excess[p] < -g->excess[end] ? g->excess[p] : -g->excess[end];
            for (uint32_t q = end; q != p; q = g->to[g->by[q] ^ 1]) {
                most = g->room[g->by[q]] < most ? g->room[g->by[q]] : most;
            }
            for (uint32_t q = end; q != p; q = g->to[g->by[q] ^ 1]) {
                g->room[g->by[q]] -= most;
                g->room[g->by[q] ^ 1] += most;
            }
            g->excess[p] -= most;
            g->excess[end] += most;
        }
    }
    g->mark++;
    for (uint32_t p = 0; p < nodes; p++) {
        if (g->excess[p] > 0 && g->marked[p] != g->mark) {
            assert_int_equal(plain_reach(g, p), UINT32_MAX);
        }
    }
}

/* Bit s = the site takes the label. E(s_p, s_q) = A + (C - A) s_p - C s_q + (B + C - A) (1 - s_p)
 * s_q, for E(1, 1) = 0. */
static void plain_edge(plain *g, const qs_model *m, const uint16_t *x, uint16_t label, uint32_t p,
                       uint32_t q, int64_t weight)
{
    int64_t stay = weight * qs_model_pairwise(m, x[p], x[q]);
    int64_t second = weight * qs_model_pairwise(m, x[p], label),
            first = weight * qs_model_pairwise(m, label, x[q]);
    g->excess[p] += stay - first;
    g->excess[q] += first;
    plain_arc(g, q, p, second + first - stay);
}

/* The best expansion move, of equals the smallest; as qs_expansion's but from nothing. */
static void plain_expand(const qs_model *m, uint16_t *x, uint16_t label)
{
    static plain g;
    g.arcs = 0;
    memset(g.first, 0xff, sizeof g.first);
    for (uint32_t p = 0; p < m->sites; p++) {
        g.excess[p] = (int64_t)m->unary[p * m->labels + x[p]] - m->unary[p * m->labels + label];
    }
    for (uint32_t p = 0; p < m->sites; p++) {
        if (m->width > 0 && m->right[p] > 0) {
            plain_edge(&g, m, x, label, p, p + 1, m->right[p]);
        }
        if (m->width > 0 && m->down[p] > 0) {
            plain_edge(&g, m, x, label, p, p + m->width, m->down[p]);
        }
        for (uint32_t n = m->width > 0 ? 0 : m->link_start[p];
             m->width == 0 && n < m->link_start[p + 1]; n++) {
            if (m->links[n].site > p) {
                plain_edge(&g, m, x, label, p, m->links[n].site, m->links[n].weight);
            }
        }
    }
    plain_flow(&g, m->sites);
    for (uint32_t p = 0; p < m->sites; p++) {
        x[p] = g.marked[p] == g.mark ? label : x[p];
    }
}

/* A solver, with memory of exactly its size that holds rubbish. */
static qs_status solve(qs_solver *solver, size_t workspace(const qs_model *), const qs_model *m,
                       const qs_solve_options *options, uint16_t *x, qs_solution *solution)
{
    size_t size = workspace(m);
    void *memory = malloc(size);
    assert_non_null(memory);
    memset(memory, 0xa5, size);
    qs_status status = solver(m, options, memory, size, x, solution);
    free(memory);
    return status;
}

static void random_labelling(const qs_model *m, uint64_t *state, uint16_t *x)
{
    for (uint32_t p = 0; p < m->sites; p++) {
        x[p] = (uint16_t)tiny_random(state, m->labels);
    }
}

/* Follows a solver move by move. */
typedef struct follower {
    const qs_model *model;
    uint16_t x[MANY];
    uint64_t moves, stop; /* stop after so many; 0 = never */
    uint64_t calls;
    int64_t last;
} follower;

/* Makes moves until one of a cycle gains. */
static int64_t go_to_gain(follower *f)
{
    int64_t before = qs_model_energy(f->model, f->x), after = before;
    for (uint32_t i = 0; i < f->model->labels && after == before; i++) {
        plain_expand(f->model, f->x, (uint16_t)(f->moves++ % f->model->labels));
        after = qs_model_energy(f->model, f->x);
    }
    return after;
}

/* The watch is called within moves, too, before they have changed anything. */
static bool follow_expansion(void *context, const qs_progress *progress)
{
    follower *f = context;
    f->calls++;
    assert_int_equal(progress->lower_bound, QS_NO_BOUND);
    if (progress->energy != qs_model_energy(f->model, f->x)) {
        assert_int_equal(progress->energy, go_to_gain(f));
        assert_int_equal(progress->iteration, (f->moves - 1) / f->model->labels + 1);
    }
    return true;
}

static void follow_field(const field *f, uint64_t *state)
{
    static follower walk;
    static uint16_t x[MANY];
    qs_solution solution;
    random_labelling(&f->model, state, x);
    walk = (follower){.model = &f->model};
    memcpy(walk.x, x, sizeof x);
    qs_solve_options options = {.watch = follow_expansion, .context = &walk};
    assert_int_equal(solve(qs_expansion, qs_expansion_workspace, &f->model, &options, x, &solution),
                     QS_OK);
    assert_memory_equal(x, walk.x, sizeof *x * f->model.sites);
    assert_int_equal(solution.energy, qs_model_energy(&f->model, x));
    assert_true(solution.converged && walk.calls >= walk.moves + f->model.labels);
    assert_int_equal(solution.energy, go_to_gain(&walk));
}

/* Every move, one after the other, is the one of a flow from nothing. */
static void expansion_move_by_move(void **unused)
{
    (void)unused;
    static field f;
    uint64_t state = 11;
    for (int round = 0; round < 200; round++) {
        const qs_smoothness kinds[] = {QS_POTTS, QS_TRUNCATED_LINEAR, QS_TABLE, QS_POTTS};
        /* One after the other: compilers differ in which argument they evaluate first. */
        const int32_t weight = 1 + (int32_t)tiny_random(&state, 20);
        const uint32_t bits = (uint32_t)tiny_random(&state, 8);
        const uint32_t cost = 2 + (uint32_t)tiny_random(&state, 1u << bits);
        field_make(&f, &state, round % 3 > 0, kinds[round % 4], weight, cost);
        follow_field(&f, &state);
    }
}

/* Weights so large that the duals must often begin anew. */
static void expansion_at_the_edge_of_its_range(void **unused)
{
    (void)unused;
    static field f;
    uint64_t state = 12;
    for (int round = 0; round < 40; round++) {
        field_make(&f, &state, round % 3 > 0, round % 2 ? QS_POTTS : QS_TRUNCATED_LINEAR,
                   (round % 2 ? 2 : 1) << 22, 1 << 26);
        follow_field(&f, &state);
    }
}

/* The cost of a source side of a cut. */
static int64_t cut_cost(const int32_t *excess, uint32_t nodes, const tiny_edge *edges,
                        const int32_t (*room)[2], size_t count, uint32_t side)
{
    int64_t cost = 0;
    for (uint32_t p = 0; p < nodes; p++) {
        bool in = side >> p & 1;
        cost += in && excess[p] < 0 ? -excess[p] : !in && excess[p] > 0 ? excess[p] : 0;
    }
    for (size_t i = 0; i < count; i++) {
        bool p = side >> edges[i].p & 1, q = side >> edges[i].q & 1;
        cost += p && !q ? room[i][0] : q && !p ? room[i][1] : 0;
    }
    return cost;
}

/* Lays a tiny problem's edges out for a cut. */
typedef struct tiny_cut {
    qs_cut cut;
    qs_cut_node node[3 * TINY_SITES];
    int32_t excess[TINY_SITES], residual[4 * TINY_SITES + 2 * TINY_EDGES];
    uint32_t start[TINY_SITES + 1], sister[2 * TINY_EDGES], queue[TINY_SITES], orphan[TINY_SITES];
    qs_link links[2 * TINY_EDGES];
} tiny_cut;

static void lay_out_grid(tiny_cut *t, uint32_t width, const tiny_edge *edges,
                         const int32_t (*room)[2], size_t count)
{
    t->cut.width = width;
    t->cut.node = t->node + width;
    for (size_t i = 0; i < count; i++) {
        bool right = edges[i].q == edges[i].p + 1 && edges[i].q % width != 0;
        t->residual[(right ? QS_CUT_RIGHT : QS_CUT_DOWN) * t->cut.nodes + edges[i].p] += room[i][0];
        t->residual[(right ? QS_CUT_LEFT : QS_CUT_UP) * t->cut.nodes + edges[i].q] += room[i][1];
    }
}

static void lay_out_graph(tiny_cut *t, const tiny_edge *edges, const int32_t (*room)[2],
                          size_t count)
{
    uint32_t at = 0, first[TINY_EDGES];
    for (uint32_t p = 0; p < t->cut.nodes; p++) {
        t->start[p] = at;
        for (size_t i = 0; i < count; i++) {
            if (edges[i].q == p) {
                t->sister[at] = first[i];
                t->sister[first[i]] = at;
            }
            first[i] = edges[i].p == p ? at : first[i];
            if (edges[i].p == p || edges[i].q == p) {
                t->residual[at] = room[i][edges[i].q == p];
                t->links[at++].site = edges[i].q == p ? edges[i].p : edges[i].q;
            }
        }
    }
    t->start[t->cut.nodes] = at;
    t->cut.node = t->node;
    t->cut.start = t->start;
    t->cut.links = t->links;
    t->cut.sister = t->sister;
}

static void run_cut(tiny_cut *t, int how)
{
    uint32_t list[TINY_SITES];
    qs_cut_begin(&t->cut);
    for (uint32_t p = 0; p < t->cut.nodes; p++) {
        list[p] = p;
    }
    if (how == 1) {
        qs_cut_spread(&t->cut);
    } else if (how == 2) {
        qs_cut_spread_some(&t->cut, list, t->cut.nodes);
    } else if (how == 3) {
        t->cut.time = UINT32_MAX - 3; /* the clock will be full, more than once */
    }
    for (uint32_t p = 0; p < t->cut.nodes; p++) {
        if (t->excess[p] > 0) {
            qs_cut_source(&t->cut, p);
        }
    }
    qs_cut_run(&t->cut);
}

/* The tree is the smallest of the cheapest source sides, and what was sent is its cost. */
static void check_cut(const qs_problem *problem, uint64_t *state, int how)
{
    static tiny_cut t;
    tiny_edge edges[TINY_EDGES];
    int32_t room[TINY_EDGES][2], excess[TINY_SITES];
    uint32_t nodes =
        problem->grid.width > 0 ? problem->grid.width * problem->grid.height : problem->sites;
    size_t count = tiny_edges(problem, edges);
    memset(&t, 0, sizeof t);
    memset(t.node, 0xff, sizeof t.node);
    t.cut = (qs_cut){.nodes = nodes,
                     .excess = t.excess,
                     .residual = t.residual,
                     .queue = t.queue,
                     .orphan = t.orphan};
    for (size_t i = 0; i < count; i++) {
        room[i][0] = (int32_t)tiny_random(state, 9);
        room[i][1] = tiny_random(state, 3) == 0 ? 0 : (int32_t)tiny_random(state, 9);
    }
    if (problem->grid.width > 0) {
        lay_out_grid(&t, problem->grid.width, edges, (const int32_t (*)[2])room, count);
    } else {
        lay_out_graph(&t, edges, (const int32_t (*)[2])room, count);
    }
    int64_t sent = 0, least = INT64_MAX;
    uint32_t smallest = 0, tree = 0;
    for (uint32_t p = 0; p < nodes; p++) {
        t.cut.node[p] = (qs_cut_node){.parent = QS_CUT_FREE};
        excess[p] = t.excess[p] = (int32_t)tiny_random(state, 30) - 17;
        sent += excess[p] > 0 ? excess[p] : 0;
    }
    run_cut(&t, how);
    for (uint32_t p = 0; p < nodes; p++) {
        sent -= t.excess[p] > 0 ? t.excess[p] : 0;
        tree |= (uint32_t)qs_cut_in_tree(&t.cut.node[p]) << p;
    }
    for (uint32_t side = 0; side < 1u << nodes; side++) {
        int64_t cost = cut_cost(excess, nodes, edges, (const int32_t (*)[2])room, count, side);
        smallest = cost < least ? side : cost == least ? smallest & side : smallest;
        least = cost < least ? cost : least;
    }
    assert_int_equal(tree, smallest);
    if (how == 0 || how == 3) { /* else some was sent to other excesses */
        assert_int_equal(sent, least);
    }
}

static void cuts_are_the_cheapest(void **unused)
{
    (void)unused;
    uint64_t state = 13;
    for (int round = 0; round < 4000; round++) {
        tiny t;
        do {
            tiny_make(&t, &state, 11, true);
            t.problem.grid.mask = NULL;
        } while (t.problem.grid.width == 0 && t.problem.sites < 2);
        check_cut(&t.problem, &state, round % 4);
    }
}

/* A model of a tiny problem, and its memory. */
typedef struct tiny_model {
    tiny t;
    tiny_qubo q;
    uint64_t memory[2048];
    qs_model model;
} tiny_model;

static void make_model(tiny_model *m, uint64_t *state, bool potts)
{
    do {
        tiny_make(&m->t, state, BITS, potts);
    } while (m->t.problem.edge_count > TINY_EDGES);
    tiny_encode(&m->t.problem,
                (qs_encode_options){potts ? QS_ONE_HOT_SPARSE : QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 0},
                &m->q);
    assert_true(qs_model_workspace(&m->q.qubo) <= sizeof m->memory);
    assert_int_equal(qs_model_build(&m->q.index, m->memory, sizeof m->memory, &m->model), QS_OK);
}

static bool semi_metric(const qs_model *m)
{
    bool good = true;
    for (uint32_t a = 0; a < m->labels; a++) {
        good = good && qs_model_pairwise(m, a, a) == 0;
        for (uint32_t b = 0; b < m->labels; b++) {
            good = good && qs_model_pairwise(m, a, b) == qs_model_pairwise(m, b, a);
        }
    }
    return good;
}

static bool metric(const qs_model *m)
{
    bool good = semi_metric(m);
    for (uint32_t a = 0; a < m->labels; a++) {
        for (uint32_t b = 0; b < m->labels; b++) {
            for (uint32_t c = 0; c < m->labels; c++) {
                good = good && qs_model_pairwise(m, a, c) <=
                                   qs_model_pairwise(m, a, b) + qs_model_pairwise(m, b, c);
            }
        }
    }
    return good;
}

/* Makes a table symmetric, and often a metric. */
static void mend_table(tiny_model *m, uint64_t *state)
{
    int32_t *table = (int32_t *)(void *)m->model.pairwise.table,
            least = (int32_t)tiny_random(state, 4);
    m->model.pairwise_max = 0;
    for (uint32_t a = 0; a < m->model.labels; a++) {
        for (uint32_t b = 0; b <= a; b++) {
            int32_t cost = a == b ? 0 : table[a * m->model.labels + b];
            cost = a != b && cost < least ? least : cost;
            table[a * m->model.labels + b] = table[b * m->model.labels + a] = cost;
            m->model.pairwise_max = cost > m->model.pairwise_max ? cost : m->model.pairwise_max;
        }
    }
}

static void no_expansion_is_better(const qs_model *m, const uint16_t *x, int64_t energy)
{
    for (uint16_t a = 0; a < m->labels; a++) {
        for (uint32_t set = 0; set < 1u << m->sites; set++) {
            uint16_t y[TINY_SITES];
            for (uint32_t p = 0; p < m->sites; p++) {
                y[p] = set >> p & 1 ? a : x[p];
            }
            assert_true(qs_model_energy(m, y) >= energy);
        }
    }
}

static void no_swap_is_better(const qs_model *m, const uint16_t *x, int64_t energy)
{
    for (uint16_t a = 0; a < m->labels; a++) {
        for (uint16_t b = 0; b < a; b++) {
            for (uint32_t set = 0; set < 1u << m->sites; set++) {
                uint16_t y[TINY_SITES];
                for (uint32_t p = 0; p < m->sites; p++) {
                    y[p] = x[p] != a && x[p] != b ? x[p] : set >> p & 1 ? a : b;
                }
                assert_true(qs_model_energy(m, y) >= energy);
            }
        }
    }
}

/* Both solvers on one model: not above the start, twice the same; a local optimum where no term had
 * to be cut down. */
static void check_model(const qs_model *m, uint64_t *state, uint32_t *solved)
{
    for (int which = 0; which < 2; which++) {
        qs_solver *solver = which ? qs_swap : qs_expansion;
        size_t (*workspace)(const qs_model *) = which ? qs_swap_workspace : qs_expansion_workspace;
        uint16_t start[TINY_SITES], x[TINY_SITES], again[TINY_SITES];
        qs_solution solution, second;
        random_labelling(m, state, start);
        memcpy(x, start, sizeof x);
        memcpy(again, start, sizeof x);
        assert_int_equal(solve(solver, workspace, m, NULL, x, &solution), QS_OK);
        assert_int_equal(solution.energy, qs_model_energy(m, x));
        assert_true(solution.energy <= qs_model_energy(m, start));
        assert_true(solution.converged && solution.lower_bound == QS_NO_BOUND &&
                    (solution.iterations > 0 || m->labels == 1));
        if (which ? semi_metric(m) : metric(m)) {
            solved[which]++;
            which ? no_swap_is_better(m, x, solution.energy)
                  : no_expansion_is_better(m, x, solution.energy);
        }
        assert_int_equal(solve(solver, workspace, m, NULL, again, &second), QS_OK);
        assert_memory_equal(x, again, sizeof *x * m->sites);
    }
}

static void local_optima(void **unused)
{
    (void)unused;
    static tiny_model m;
    uint64_t state = 14;
    uint32_t solved[2] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        make_model(&m, &state, round % 3 == 0);
        if (m.model.pairwise.smoothness == QS_TABLE && round % 2 == 0) {
            mend_table(&m, &state);
        }
        check_model(&m.model, &state, solved);
    }
    assert_true(solved[0] > ROUNDS / 2 && solved[1] > solved[0]);
}

/* What a table lacks, one fault at a time. */
static void metrics(void **unused)
{
    (void)unused;
    static const struct {
        int32_t table[9];
        bool metric, semi_metric;
    } cases[] = {
        {{0, 1, 2, 1, 0, 1, 2, 1, 0}, true, true},   {{0, 0, 0, 0, 0, 0, 0, 0, 0}, true, true},
        {{0, 1, 3, 1, 0, 1, 3, 1, 0}, false, true},  {{0, 1, 2, 1, 0, 1, 1, 1, 0}, false, false},
        {{0, 1, 1, 1, 1, 1, 1, 1, 0}, false, false},
    };
    const int32_t unary[3] = {0, 1, 2}, weight = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        qs_model m = {.sites = 1,
                      .labels = 3,
                      .unary = unary,
                      .pairwise = {QS_TABLE, 0, cases[i].table},
                      .pairwise_max = 3,
                      .width = 1,
                      .height = 1,
                      .right = &weight,
                      .down = &weight};
        uint16_t x = 2;
        qs_solution solution;
        assert_int_equal(qs_is_metric(&m), cases[i].metric);
        assert_int_equal(qs_is_semi_metric(&m), cases[i].semi_metric);
        assert_int_equal(solve(qs_expansion, qs_expansion_workspace, &m, NULL, &x, &solution),
                         QS_OK);
        assert_int_equal(x, 0);
        x = 2;
        assert_int_equal(solve(qs_swap, qs_swap_workspace, &m, NULL, &x, &solution), QS_OK);
        assert_int_equal(x, 0);
    }
    for (uint32_t labels = 1; labels <= 5; labels++) {
        for (uint32_t truncation = 0; truncation <= 5; truncation++) {
            const int32_t none[5] = {0};
            qs_model m = {.sites = 1,
                          .labels = labels,
                          .unary = none,
                          .pairwise = {QS_TRUNCATED_QUADRATIC, truncation, NULL},
                          .pairwise_max = 16,
                          .width = 1,
                          .height = 1,
                          .right = &weight,
                          .down = &weight};
            assert_int_equal(qs_is_metric(&m), metric(&m));
        }
    }
}

/* A second run looks at every pair again, where the first passed over those that seemed unchanged.
 */
static void swap_again_finds_nothing(void **unused)
{
    (void)unused;
    static field f;
    static uint16_t x[MANY];
    uint64_t state = 17;
    for (int round = 0; round < 150; round++) {
        const qs_smoothness kinds[] = {QS_POTTS, QS_TRUNCATED_LINEAR, QS_TABLE};
        qs_solution first, again;
        field_make(&f, &state, round % 2 > 0, kinds[round % 3],
                   1 + (int32_t)tiny_random(&state, 20), 60);
        random_labelling(&f.model, &state, x);
        int64_t start = qs_model_energy(&f.model, x);
        assert_int_equal(solve(qs_swap, qs_swap_workspace, &f.model, NULL, x, &first), QS_OK);
        assert_true(first.energy <= start && first.converged);
        assert_int_equal(first.energy, qs_model_energy(&f.model, x));
        assert_int_equal(solve(qs_swap, qs_swap_workspace, &f.model, NULL, x, &again), QS_OK);
        assert_int_equal(again.energy, first.energy);
    }
}

/* The second site changes from 2 to 3 last of all, and only then label 1 is the better one for the
 * first. */
static void swap_looks_again_at_neighbours(void **unused)
{
    (void)unused;
    const int32_t table[16] = {0, 1, 1, 3, 1, 0, 3, 1, 1, 3, 0, 1, 3, 1, 1, 0};
    const int32_t unary[8] = {0, 0, 100, 100, 100, 100, 50, 0}, right[2] = {10, 0},
                  down[2] = {0, 0};
    qs_model m = {.sites = 2,
                  .labels = 4,
                  .unary = unary,
                  .pairwise = {QS_TABLE, 0, table},
                  .pairwise_max = 3,
                  .width = 2,
                  .height = 1,
                  .right = right,
                  .down = down};
    uint16_t x[2] = {0, 2};
    qs_solution solution;
    assert_int_equal(solve(qs_swap, qs_swap_workspace, &m, NULL, x, &solution), QS_OK);
    assert_int_equal(solution.energy, 10);
    assert_int_equal(x[0], 1);
    assert_int_equal(x[1], 3);
}

static bool stop_there(void *context, const qs_progress *progress)
{
    follower *f = context;
    assert_true(progress->energy <= f->last);
    f->last = progress->energy;
    return ++f->moves != f->stop;
}

/* A watch's word and a number of cycles both stop, with the energy of the labelling that is there.
 */
static void stops_when_told(void **unused)
{
    (void)unused;
    static field f;
    static uint16_t start[MANY], x[MANY];
    uint64_t state = 15;
    for (int round = 0; round < 60; round++) {
        qs_solver *solver = round % 2 ? qs_swap : qs_expansion;
        size_t (*workspace)(const qs_model *) =
            round % 2 ? qs_swap_workspace : qs_expansion_workspace;
        do {
            field_make(&f, &state, round % 3 > 0, QS_POTTS, 10, 60);
        } while (f.model.labels < 3 || f.model.sites < 40);
        random_labelling(&f.model, &state, start);
        for (uint64_t stop = 1; stop <= 4; stop++) {
            follower walk = {.stop = stop, .last = qs_model_energy(&f.model, start)};
            qs_solve_options options = {.watch = stop_there, .context = &walk};
            qs_solution solution;
            memcpy(x, start, sizeof x);
            assert_int_equal(solve(solver, workspace, &f.model, &options, x, &solution), QS_OK);
            assert_int_equal(walk.moves, stop);
            assert_false(solution.converged);
            assert_int_equal(solution.energy, qs_model_energy(&f.model, x));
            assert_int_equal(solution.energy, walk.last);
        }
        qs_solve_options once = {.iterations = 1};
        qs_solution solution;
        memcpy(x, start, sizeof x);
        assert_int_equal(solve(solver, workspace, &f.model, &once, x, &solution), QS_OK);
        assert_int_equal(solution.iterations, 1);
        assert_false(solution.converged);
    }
}

static void refusals(void **unused)
{
    (void)unused;
    static field f;
    static uint16_t x[MANY];
    uint64_t state = 16;
    qs_solution solution = {.energy = 5};
    do {
        field_make(&f, &state, true, QS_POTTS, 10, 60);
    } while (f.model.labels < 2 || f.model.sites < 40 || f.right[0] == 0);
    for (int which = 0; which < 2; which++) {
        qs_solver *solver = which ? qs_swap : qs_expansion;
        size_t (*workspace)(const qs_model *) = which ? qs_swap_workspace : qs_expansion_workspace;
        size_t size = workspace(&f.model);
        void *memory = malloc(size);
        assert_int_equal(solver(&f.model, NULL, memory, size - 1, x, &solution), QS_E_WORKSPACE);
        assert_int_equal(solver(NULL, NULL, memory, size, x, &solution), QS_E_ARGUMENT);
        assert_int_equal(solver(&f.model, NULL, NULL, size, x, &solution), QS_E_ARGUMENT);
        assert_int_equal(solver(&f.model, NULL, memory, size, NULL, &solution), QS_E_ARGUMENT);
        assert_int_equal(solver(&f.model, NULL, memory, size, x, NULL), QS_E_ARGUMENT);
        x[7] = (uint16_t)f.model.labels;
        assert_int_equal(solver(&f.model, NULL, memory, size, x, &solution), QS_E_ARGUMENT);
        x[7] = 0;
        for (int fault = 0; fault < 3; fault++) {
            field g = f;
            g.model.unary = g.unary;
            g.model.right = g.right;
            g.unary[3] = fault == 0 ? INT32_MAX : g.unary[3];
            g.right[0] = fault == 1 ? 1 << 29 : g.right[0];
            g.model.pairwise_max = fault == 2 ? INT64_C(4294705156) : 1;
            size_t larger = workspace(&g.model);
            assert_true(larger > size); /* in 64 bits */
            assert_int_equal(solver(&g.model, NULL, memory, size, x, &solution), QS_E_WORKSPACE);
            assert_int_equal(solution.energy, 5);
            void *more = malloc(larger);
            qs_solution moved;
            qs_model_winner(&g.model, x);
            assert_int_equal(solver(&g.model, NULL, more, larger, x, &moved), QS_OK);
            assert_int_equal(moved.energy, qs_model_energy(&g.model, x));
            free(more);
        }
        free(memory);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cuts_are_the_cheapest),
        cmocka_unit_test(local_optima),
        cmocka_unit_test(expansion_move_by_move),
        cmocka_unit_test(expansion_at_the_edge_of_its_range),
        cmocka_unit_test(swap_again_finds_nothing),
        cmocka_unit_test(swap_looks_again_at_neighbours),
        cmocka_unit_test(metrics),
        cmocka_unit_test(stops_when_told),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("moves", tests, NULL, NULL);
}
