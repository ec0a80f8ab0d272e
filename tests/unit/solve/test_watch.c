/* A watch within an iteration: on a problem so large that each iteration takes some looks. */
#include "tiny.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 256, HEIGHT = 132, LABELS = 32, SITES = WIDTH * HEIGHT, FEW = 20 };

static int32_t unary[SITES * LABELS], right[SITES], down[SITES];
static qs_model model;

/* Slanted stripes with noise. */
static void make(qs_smoothness smoothness)
{
    uint64_t state = 1;
    model = (qs_model){.sites = SITES,
                       .labels = LABELS,
                       .width = WIDTH,
                       .height = HEIGHT,
                       .constant = 1000,
                       .unary = unary,
                       .right = right,
                       .down = down,
                       .pairwise = {smoothness, 3, NULL},
                       .pairwise_max = smoothness == QS_POTTS ? 1 : 3};
    for (uint32_t p = 0; p < SITES; p++) {
        right[p] = (p + 1) % WIDTH != 0 ? 9 : 0;
        down[p] = p + WIDTH < SITES ? 9 : 0;
        for (uint32_t d = 0; d < LABELS; d++) {
            bool here = d == (p % WIDTH + p / WIDTH) / 16 % LABELS;
            unary[p * LABELS + d] = (here ? 0 : 10) + (int32_t)tiny_random(&state, 30);
        }
        int32_t *costs = unary + p * LABELS, least = INT32_MAX;
        for (uint32_t d = 0; d < LABELS; d++) {
            least = costs[d] < least ? costs[d] : least;
        }
        for (uint32_t d = 0; d < LABELS; d++) {
            costs[d] -= least;
        }
    }
}

typedef struct witness {
    const uint16_t *labelling;
    uint32_t calls, stop; /* at this call; 0 = never */
    uint64_t iteration; /* of the last call */
    uint32_t within; /* calls at an iteration that was told before */
    int64_t energy;
} witness;

static bool watch(void *context, const qs_progress *progress)
{
    witness *w = context;
    w->calls++;
    w->within += progress->iteration == w->iteration;
    w->iteration = progress->iteration;
    w->energy = progress->energy;
    assert_int_equal(progress->energy, qs_model_energy(&model, w->labelling));
    return w->calls != w->stop;
}

/* Runs a solver until the watch stops it. Returns how often it was called within iterations. */
static uint32_t run(qs_solver *solve, size_t size, uint64_t iterations, uint32_t stop)
{
    static uint16_t x[SITES];
    void *memory = malloc(size);
    assert_non_null(memory);
    memset(memory, 0xa5, size);
    qs_model_winner(&model, x);
    int64_t start = qs_model_energy(&model, x);
    witness w = {.labelling = x, .stop = stop};
    qs_solve_options options = {.iterations = iterations, .watch = watch, .context = &w};
    qs_solution s;
    assert_int_equal(solve(&model, &options, memory, size, x, &s), QS_OK);
    free(memory);
    assert_int_equal(s.energy, qs_model_energy(&model, x));
    assert_true(s.energy <= start);
    assert_true(s.lower_bound == QS_NO_BOUND || s.lower_bound <= s.energy);
    assert_true(stop == 0 || w.calls == stop);
    assert_true(stop == 0 || !s.converged);
    return w.within;
}

static const struct {
    qs_solver *solve;
    size_t (*workspace)(const qs_model *);
} solvers[] = {
    {qs_icm, qs_icm_workspace},   {qs_anneal, qs_anneal_workspace},
    {qs_bp, qs_bp_workspace},     {qs_expansion, qs_expansion_workspace},
    {qs_trws, qs_trws_workspace}, {qs_best, qs_best_workspace},
};
enum { SOLVERS = sizeof solvers / sizeof *solvers };

static void looks_and_stops(void **unused)
{
    (void)unused;
    for (int potts = 0; potts < 2; potts++) {
        make(potts ? QS_POTTS : QS_TRUNCATED_LINEAR);
        for (size_t i = 0; i < SOLVERS; i++) {
            size_t size = solvers[i].workspace(&model) + 1;
            assert_true(run(solvers[i].solve, size, 2, 0) > 0);
            for (uint32_t stop = 1; stop < 4; stop++) {
                (void)run(solvers[i].solve, size, 2, stop);
            }
        }
    }
}

enum {
    LEAVES = 8000,
    JOINED = 300,
    EDGES = JOINED * (JOINED - 1) / 2,
    GRAPH_LABELS = 12,
    SOME = 6
};

/* A graph of edges that are in order. Costs and weights are drawn. */
static void make_graph(uint32_t sites, uint32_t labels, qs_edge *edges, size_t count, void **memory)
{
    uint64_t state = 2;
    for (size_t e = 0; e < count; e++) {
        edges[e].weight = 1 + (int32_t)tiny_random(&state, 9);
    }
    for (uint32_t i = 0; i < sites * labels; i++) {
        unary[i] = (int32_t)tiny_random(&state, 100);
    }
    qs_problem problem = {.sites = sites,
                          .labels = labels,
                          .scale = 1,
                          .pairwise = {QS_TRUNCATED_LINEAR, 3, NULL},
                          .edges = edges,
                          .edge_count = count,
                          .costs = unary};
    size_t size = qs_model_of_problem_workspace(&problem);
    *memory = malloc(size);
    assert_int_equal(qs_model_of_problem(&problem, *memory, size, &model, NULL), QS_OK);
}

/* A site with thousands of neighbours, which have neighbours of their own: a single move of all
 * that looks along all its edges again and again. */
static void looks_within_a_move_at_a_hub(void **unused)
{
    (void)unused;
    static qs_edge edges[2 * LEAVES];
    size_t count = 0;
    void *memory;
    for (uint32_t p = 1; p <= LEAVES; p++) {
        edges[count++] = (qs_edge){.first = 0, .second = p};
    }
    for (uint32_t p = 1; p < LEAVES; p++) {
        edges[count++] = (qs_edge){.first = p, .second = p + 1};
    }
    make_graph(LEAVES + 1, 2, edges, count, &memory);
    /* A cycle has two moves here, or one. So most of these looks are within a move. */
    (void)run(qs_expansion, qs_expansion_workspace(&model), 1, SOME);
    (void)run(qs_swap, qs_swap_workspace(&model), 1, SOME);
    free(memory);
}

static bool stop_after_two(void *context, const qs_progress *unused)
{
    (void)unused;
    return ++*(uint32_t *)context < 2;
}

/* A cut that has hardly begun has no labelling; best has one that is better than the winner's. */
static void best_has_an_answer_before_the_cut(void **unused)
{
    (void)unused;
    static qs_edge edges[LEAVES];
    static uint16_t x[LEAVES + 1];
    void *memory;
    for (uint32_t p = 0; p < LEAVES; p++) {
        edges[p] = (qs_edge){.first = p, .second = p + 1};
    }
    make_graph(LEAVES + 1, 2, edges, LEAVES, &memory);
    qs_model_winner(&model, x);
    int64_t winner = qs_model_energy(&model, x);
    size_t size = qs_best_workspace(&model);
    void *workspace = malloc(size);
    uint32_t calls = 0;
    qs_solve_options options = {.watch = stop_after_two, .context = &calls};
    qs_solution s;
    assert_int_equal(qs_best(&model, &options, workspace, size, x, &s), QS_OK);
    assert_true(calls == 2 && s.energy < winner && s.energy == qs_model_energy(&model, x));
    free(workspace);
    free(memory);
}

/* All sites are neighbours: each is a long way to go. */
static void looks_where_there_are_many_edges(void **unused)
{
    (void)unused;
    static qs_edge edges[EDGES];
    size_t count = 0;
    void *memory;
    for (uint32_t p = 0; p < JOINED; p++) {
        for (uint32_t q = p + 1; q < JOINED; q++) {
            edges[count++] = (qs_edge){.first = p, .second = q};
        }
    }
    make_graph(JOINED, GRAPH_LABELS, edges, count, &memory);
    for (size_t i = 0; i < SOLVERS; i++) {
        assert_true(run(solvers[i].solve, solvers[i].workspace(&model) + 1, 1, 0) > 0);
    }
    free(memory);
}

/* Solvers with a bound have one at the first call: no cost is below 0. */
static bool has_bound(void *context, const qs_progress *progress)
{
    *(int64_t *)context = progress->lower_bound;
    return false;
}

static void bounds_come_early(void **unused)
{
    (void)unused;
    static uint16_t x[SITES];
    make(QS_POTTS);
    for (int i = 0; i < 2; i++) {
        size_t size = i ? qs_best_workspace(&model) : qs_trws_workspace(&model);
        void *memory = malloc(size);
        int64_t told = QS_NO_BOUND;
        qs_solve_options options = {.watch = has_bound, .context = &told};
        qs_solution s;
        assert_int_equal((i ? qs_best : qs_trws)(&model, &options, memory, size, x, &s), QS_OK);
        assert_true(told >= model.constant && told == s.lower_bound);
        assert_int_equal(s.iterations, 0);
        free(memory);
    }
}

static bool note_first(void *context, const qs_reduction *so_far)
{
    qs_reduction *first = context;
    *first = *so_far;
    return false;
}

/* A reduction looks before the first labels have left, too, and has an answer then. */
static void reduce_looks_from_the_beginning(void **unused)
{
    (void)unused;
    static uint16_t x[SITES];
    static uint8_t kept[SITES * LABELS];
    make(QS_POTTS);
    size_t size = qs_reduce_workspace(&model);
    void *memory = malloc(size);
    qs_reduction first = {0}, found;
    qs_reduce_options options = {.watch = note_first, .context = &first};
    assert_int_equal(qs_reduce(&model, &options, memory, size, kept, x, &found), QS_OK);
    free(memory);
    assert_int_equal(first.variables, SITES * LABELS);
    assert_int_equal(first.upper_bound, qs_model_energy(&model, x));
    assert_true(first.lower_bound == model.constant && found.lower_bound >= model.constant);
    assert_true(found.upper_bound == first.upper_bound && found.iterations == 0);
}

/* A clock that goes on by so much at each look. */
typedef struct watched_time {
    uint32_t now, step, sweeps;
} watched_time;

static uint32_t spent(void *context)
{
    watched_time *t = context;
    t->sweeps++;
    t->now = t->now + t->step < QS_ALL_TIME ? t->now + t->step : QS_ALL_TIME;
    return t->now;
}

/* Annealing takes the time that it is told it has, and ends cold in it. */
static void anneal_follows_the_time(void **unused)
{
    (void)unused;
    static uint16_t x[SITES];
    static uint64_t memory[SITES / 4 + 1];
    make(QS_POTTS);
    for (uint32_t sweeps = 4; sweeps <= FEW; sweeps += 8) {
        watched_time t = {.step = QS_ALL_TIME / sweeps};
        qs_solve_options options = {.spent = spent, .context = &t};
        qs_solution s;
        qs_model_winner(&model, x);
        assert_int_equal(qs_anneal(&model, &options, memory, sizeof memory, x, &s), QS_OK);
        assert_true(t.sweeps <= sweeps && t.sweeps + 2 >= sweeps);
        assert_int_equal(s.iterations, t.sweeps);
        assert_true(s.converged);
    }
}

typedef struct gap_witness {
    int64_t parts; /* of a million */
    uint64_t first; /* the iteration after which the gap was small enough */
} gap_witness;

static bool watch_gap(void *context, const qs_progress *progress)
{
    gap_witness *w = context;
    bool near = progress->energy - progress->lower_bound <= progress->energy * w->parts / 1000000;
    w->first = near && w->first == 0 ? progress->iteration : w->first;
    return !near;
}

/* A watch can stop it as soon as the gap is small enough. */
static void best_stops_at_a_gap(void **unused)
{
    (void)unused;
    static uint16_t x[SITES];
    uint64_t all = 0;
    make(QS_TRUNCATED_LINEAR);
    size_t size = qs_best_workspace(&model);
    void *memory = malloc(size);
    for (uint32_t gap = 10000; gap > 10; gap /= 10) {
        gap_witness w = {.parts = gap};
        qs_solve_options options = {.watch = watch_gap, .context = &w};
        qs_solution s;
        assert_int_equal(qs_best(&model, &options, memory, size, x, &s), QS_OK);
        assert_true(s.energy - s.lower_bound <= s.energy * gap / 1000000);
        assert_int_equal(s.iterations, w.first);
        all += s.iterations;
    }
    assert_true(all > 3);
    free(memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looks_and_stops),
        cmocka_unit_test(looks_within_a_move_at_a_hub),
        cmocka_unit_test(looks_where_there_are_many_edges),
        cmocka_unit_test(best_has_an_answer_before_the_cut),
        cmocka_unit_test(bounds_come_early),
        cmocka_unit_test(reduce_looks_from_the_beginning),
        cmocka_unit_test(anneal_follows_the_time),
        cmocka_unit_test(best_stops_at_a_gap),
    };
    return cmocka_run_group_tests_name("watch", tests, NULL, NULL);
}
