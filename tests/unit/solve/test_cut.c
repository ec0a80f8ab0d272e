/* The solver `cut` against all labellings of tiny problems, and its two methods against each other
 * on larger ones. */
#include "slow.h"

#include <stdlib.h>
#include <string.h>

#include "model/convexity.h"
#include "solve/cut_descent.h"
#include "solve/cut_levels.h"

enum { ROUNDS = 2000, BITS = 20, MEMORY = 1 << 18, KINDS = 4, SIDE = 24, FIELD_LABELS = 9 };

typedef struct bench {
    tiny t;
    slow_request request;
    slow_qubo qubo;
    uint64_t model_memory[MEMORY / 8];
    qs_model model;
    int64_t minimum;
} bench;

static bench b;
static uint64_t memory[MEMORY / 8];

/* A table with mixed second differences of at most 0, no entry negative: sums of products that
 * gain, and of costs of one label alone. With two labels any of these. */
static void submodular_table(tiny *t, uint64_t *state, bool sparse)
{
    uint32_t labels = t->problem.labels;
    int32_t least = 0, *table = t->table;
    for (uint32_t a = 0; a < labels; a++) {
        for (uint32_t c = 0; c < labels; c++) {
            int32_t before = a > 0 && c > 0
                                 ? table[(a - 1) * labels + c] + table[a * labels + c - 1] -
                                       table[(a - 1) * labels + c - 1]
                                 : (int32_t)tiny_random(state, 9);
            int32_t gain = sparse && a != c ? 0 : (int32_t)tiny_random(state, 4);
            table[a * labels + c] = before - (a > 0 && c > 0 ? gain : 0);
            least = table[a * labels + c] < least ? table[a * labels + c] : least;
        }
    }
    for (uint32_t i = 0; i < labels * labels; i++) {
        table[i] -= least;
    }
}

/* g(a - c) with a convex g, not the same both ways. */
static void convex_table(tiny *t, uint64_t *state)
{
    uint32_t labels = t->problem.labels;
    int32_t rise[TINY_LABELS], fall[TINY_LABELS], slope[2] = {0, 0};
    rise[0] = fall[0] = (int32_t)tiny_random(state, 4);
    for (uint32_t d = 1; d < labels; d++) {
        slope[0] += (int32_t)tiny_random(state, 4);
        slope[1] += (int32_t)tiny_random(state, 4);
        rise[d] = rise[d - 1] + slope[0];
        fall[d] = fall[d - 1] + slope[1];
    }
    for (uint32_t a = 0; a < labels; a++) {
        for (uint32_t c = 0; c < labels; c++) {
            t->table[a * labels + c] = a < c ? rise[c - a] : fall[a - c];
        }
    }
}

static void convex_costs(tiny *t, uint64_t *state)
{
    for (uint32_t p = 0; p < TINY_SITES; p++) {
        int32_t cost = 0, slope = -(int32_t)tiny_random(state, 60);
        for (uint32_t a = 0; a < t->problem.labels; a++) {
            t->costs[p * t->problem.labels + a] = cost;
            cost += slope;
            slope += (int32_t)tiny_random(state, 40);
        }
    }
}

/* A problem whose pairwise cost is submodular, of each kind in turn. */
static void make_problem(uint64_t *state, uint32_t kind)
{
    qs_pairwise *pairwise = &b.t.problem.pairwise;
    tiny_make(&b.t, state, BITS, true);
    pairwise->table = b.t.table;
    pairwise->truncation = 0;
    switch (kind % KINDS) {
    case 0: pairwise->smoothness = QS_TRUNCATED_LINEAR; break;
    case 1: pairwise->smoothness = QS_TRUNCATED_QUADRATIC; break;
    case 2:
        pairwise->smoothness = QS_TABLE;
        submodular_table(&b.t, state, tiny_random(state, 2));
        break;
    default:
        pairwise->smoothness = QS_TABLE;
        convex_table(&b.t, state);
        break;
    }
    if (b.t.problem.labels == 2 && tiny_random(state, 2)) {
        pairwise->smoothness = QS_POTTS;
    }
}

/* Its model with all labels, or with those that the request keeps; the least energy of them. */
static void build(void)
{
    uint16_t labelling[TINY_SITES];
    b.request.problem = &b.t.problem;
    b.request.encoding = QS_ONE_HOT;
    b.request.gap = 1;
    slow_encode(&b.request, &b.qubo);
    assert_int_equal(qs_model_build(&b.qubo.index, b.model_memory, sizeof b.model_memory, &b.model),
                     QS_OK);
    b.minimum = INT64_MAX;
    slow_first(&b.request, labelling);
    do {
        int64_t energy = slow_energy(&b.t.problem, labelling);
        b.minimum = energy < b.minimum ? energy : b.minimum;
    } while (slow_next(&b.request, labelling));
}

static void keep_all(void)
{
    memset(b.request.kept, 1, sizeof b.request.kept);
}

static void random_start(uint64_t *state, uint16_t *labelling)
{
    for (uint32_t p = 0; p < b.model.sites; p++) {
        labelling[p] = (uint16_t)tiny_random(state, b.model.labels);
    }
}

static qs_solution solve(const qs_solve_options *options, uint16_t *labelling)
{
    qs_solution s;
    size_t needed = qs_min_cut_workspace(&b.model);
    assert_true(needed <= sizeof memory);
    memset(memory, 0xa5, sizeof memory);
    assert_int_equal(qs_min_cut(&b.model, options, memory, needed, labelling, &s), QS_OK);
    for (uint32_t p = 0; p < b.model.sites; p++) {
        assert_true(labelling[p] < b.model.labels);
        assert_true(!b.model.kept || b.model.kept[p * b.model.labels + labelling[p]]);
    }
    assert_int_equal(s.energy, qs_model_energy(&b.model, labelling));
    return s;
}

static void demand_proof(uint64_t *state)
{
    uint16_t labelling[TINY_SITES];
    random_start(state, labelling);
    qs_solution s = solve(NULL, labelling);
    assert_int_equal(s.energy, b.minimum);
    assert_int_equal(s.lower_bound, b.minimum);
    assert_true(s.converged);
    assert_true(s.iterations > 0);
}

static qs_status try(size_t size)
{
    qs_solution s;
    uint16_t labelling[TINY_SITES] = {0};
    return qs_min_cut(&b.model, NULL, memory, size, labelling, &s);
}

static void any_unary_costs(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    keep_all();
    for (uint32_t round = 0; round < ROUNDS; round++) {
        make_problem(&state, round);
        build();
        demand_proof(&state);
    }
}

static void convex_unary_costs(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    int descents = 0;
    keep_all();
    for (uint32_t round = 0; round < ROUNDS; round++) {
        make_problem(&state, round);
        convex_costs(&b.t, &state);
        build();
        demand_proof(&state);
        descents += qs_pairwise_is_convex(&b.model) && qs_unary_is_convex(&b.model);
    }
    assert_true(descents > ROUNDS / 2);
}

/* Problems of which labels have been left out, in sets with gaps and without. Of a table the file
 * then says only the entries that are needed, so its model's need not be submodular. */
static void labels_left(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    int refused = 0;
    for (uint32_t round = 0; round < ROUNDS; round++) {
        make_problem(&state, round);
        if (round / KINDS % 2 == 0) {
            convex_costs(&b.t, &state);
        }
        slow_choose_labels(&b.request, &state);
        build();
        if (b.t.problem.pairwise.smoothness != QS_TABLE || qs_pairwise_is_submodular(&b.model)) {
            demand_proof(&state);
        } else {
            assert_int_equal(try(sizeof memory), QS_E_ENCODING);
            refused++;
        }
    }
    assert_true(refused < ROUNDS / 2);
}

typedef struct stopper {
    uint64_t calls, last;
} stopper;

static bool stop(void *context, const qs_progress *progress)
{
    stopper *s = context;
    assert_true(progress->lower_bound <= b.minimum);
    assert_true(progress->energy >= b.minimum);
    return ++s->calls < s->last;
}

/* Stopped at each of its calls: an energy no higher than the start's, a bound that holds. */
static void stopped_by_a_watch(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    bool ended_early = false, had_bound = false;
    keep_all();
    for (uint32_t round = 0; round < ROUNDS / 10; round++) {
        make_problem(&state, round);
        if (round / KINDS % 2 == 0) {
            convex_costs(&b.t, &state);
        }
        build();
        bool more = true;
        for (uint64_t last = 1; more; last++) {
            uint16_t labelling[TINY_SITES];
            stopper watched = {.last = last};
            random_start(&state, labelling);
            int64_t before = qs_model_energy(&b.model, labelling);
            qs_solution s =
                solve(&(qs_solve_options){.watch = stop, .context = &watched}, labelling);
            assert_true(s.energy <= before);
            assert_true(s.lower_bound <= b.minimum);
            assert_int_equal(s.converged, s.lower_bound == s.energy && s.energy == b.minimum);
            more = watched.calls == last;
            ended_early = ended_early || !s.converged;
            had_bound = had_bound || (!s.converged && s.lower_bound != QS_NO_BOUND);
        }
    }
    assert_true(ended_early);
    assert_true(had_bound);
}

static void limit_of_iterations(void **unused)
{
    (void)unused;
    uint64_t state = 5;
    int stopped = 0;
    keep_all();
    for (uint32_t round = 0; round < ROUNDS / 10; round++) {
        uint16_t labelling[TINY_SITES];
        make_problem(&state, round);
        convex_costs(&b.t, &state);
        build();
        random_start(&state, labelling);
        qs_solution s = solve(&(qs_solve_options){.iterations = 1}, labelling);
        assert_int_equal(s.iterations, 1);
        stopped += !s.converged;
        assert_int_equal(s.converged, s.lower_bound == b.minimum);
    }
    assert_true(stopped > 0);
}

/* A grid of 2 x 1 sites with three labels. */
static void make_small(qs_smoothness smoothness, uint32_t truncation)
{
    memset(&b.t, 0, sizeof b.t);
    b.t.problem = (qs_problem){.labels = 3,
                               .scale = 1,
                               .weight = 7,
                               .pairwise = {smoothness, truncation, b.t.table},
                               .grid = {.width = 2, .height = 1},
                               .costs = b.t.costs};
}

static void refusals(void **unused)
{
    (void)unused;
    static const struct {
        qs_smoothness smoothness;
        uint32_t truncation;
        qs_status status;
    } cases[] = {
        {QS_POTTS, 0, QS_E_ENCODING},
        {QS_TRUNCATED_LINEAR, 0, QS_OK},
        {QS_TRUNCATED_LINEAR, 1, QS_E_ENCODING},
        {QS_TRUNCATED_LINEAR, 2, QS_OK},
        {QS_TRUNCATED_QUADRATIC, 0, QS_OK},
        {QS_TRUNCATED_QUADRATIC, 3, QS_E_ENCODING},
        {QS_TRUNCATED_QUADRATIC, 4, QS_OK},
        {QS_TABLE, 0, QS_OK},
    };
    keep_all();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        make_small(cases[i].smoothness, cases[i].truncation);
        build();
        assert_int_equal(try(sizeof memory), cases[i].status);
        assert_true((qs_min_cut_workspace(&b.model) == 0) == (cases[i].status != QS_OK));
        if (cases[i].status == QS_OK) {
            assert_int_equal(try(qs_min_cut_workspace(&b.model) - 1), QS_E_WORKSPACE);
        }
    }
    make_small(QS_TABLE, 0);
    b.t.table[4] = 1; /* V(1, 1) above the labels beside it */
    build();
    assert_int_equal(try(sizeof memory), QS_E_ENCODING);
    qs_solution s;
    uint16_t labelling[TINY_SITES] = {3};
    make_small(QS_TRUNCATED_LINEAR, 0);
    build();
    assert_int_equal(qs_min_cut(&b.model, NULL, memory, sizeof memory, labelling, &s),
                     QS_E_ARGUMENT);
    assert_int_equal(qs_min_cut(&b.model, NULL, NULL, 0, (uint16_t[TINY_SITES]){0}, &s),
                     QS_E_WORKSPACE);
}

/* Costs up to the limit of 32 bits and above it: whether convex or not. */
static void large_costs(void **unused)
{
    (void)unused;
    static const struct {
        int32_t middle, high, weight;
        qs_status status;
    } cases[] = {
        {0, 1 << 26, 7, QS_OK},       {0, INT32_MAX - 1, 7, QS_OK}, {1 << 26, 0, 7, QS_OK},
        {INT32_MAX - 1, 0, 7, QS_OK}, {0, 5, 1 << 20, QS_OK},       {0, 5, 1 << 29, QS_OK},
        {5, 0, 1 << 20, QS_OK},       {5, 0, 1 << 29, QS_OK},
    };
    uint64_t state = 6;
    keep_all();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        make_small(QS_TRUNCATED_LINEAR, 0);
        b.t.problem.weight = cases[i].weight;
        b.t.costs[1] = cases[i].middle;
        b.t.costs[2] = cases[i].high;
        b.t.costs[3] = 3;
        build();
        assert_int_equal(try(sizeof memory), cases[i].status);
        if (cases[i].status == QS_OK) {
            demand_proof(&state);
        }
    }
}

/* A larger model made by hand, convex throughout. */
typedef struct field {
    qs_model model;
    int32_t unary[SIDE * SIDE * FIELD_LABELS], right[SIDE * SIDE], down[SIDE * SIDE];
} field;

static void field_make(field *f, uint64_t *state)
{
    uint32_t width = 1 + tiny_random(state, SIDE), height = 1 + tiny_random(state, SIDE);
    memset(f, 0, sizeof *f);
    f->model = (qs_model){.sites = width * height,
                          .labels = 3 + tiny_random(state, FIELD_LABELS - 2),
                          .unary = f->unary,
                          .width = width,
                          .height = height,
                          .right = f->right,
                          .down = f->down};
    f->model.pairwise.smoothness =
        tiny_random(state, 3) == 0 ? QS_TRUNCATED_QUADRATIC : QS_TRUNCATED_LINEAR;
    f->model.pairwise_max = qs_model_pairwise(&f->model, 0, f->model.labels - 1);
    for (uint32_t p = 0; p < f->model.sites; p++) {
        int32_t best = (int32_t)tiny_random(state, f->model.labels);
        bool blank = tiny_random(state, 4) == 0; /* then flows go far */
        for (int32_t a = 0; a < (int32_t)f->model.labels; a++) {
            f->unary[(uint32_t)p * f->model.labels + (uint32_t)a] =
                blank ? 0 : 3 * (a - best) * (a - best);
        }
        f->right[p] = p % width + 1 < width ? (int32_t)tiny_random(state, 20) : 0;
        f->down[p] = p + width < f->model.sites ? (int32_t)tiny_random(state, 20) : 0;
    }
}

/* Neither method knows of the other; the bound of levels comes from the flow alone. */
static void both_agree(void **unused)
{
    (void)unused;
    uint64_t state = 7;
    static field f;
    for (int round = 0; round < 60; round++) {
        uint16_t one[SIDE * SIDE], other[SIDE * SIDE];
        qs_solution by_descent, by_levels;
        field_make(&f, &state);
        void *work = malloc(qs_levels_workspace(&f.model) + qs_descent_workspace(&f.model));
        qs_model_winner(&f.model, one);
        qs_model_winner(&f.model, other);
        assert_int_equal(qs_descent(&f.model, NULL, work, one, &by_descent), QS_OK);
        assert_int_equal(qs_levels(&f.model, NULL, work, other, &by_levels), QS_OK);
        free(work);
        assert_int_equal(by_descent.energy, by_levels.energy);
        assert_int_equal(by_levels.lower_bound, by_levels.energy);
        assert_int_equal(qs_model_energy(&f.model, one), by_descent.energy);
        assert_int_equal(qs_model_energy(&f.model, other), by_levels.energy);
    }
}

/* Costs on a line, of which labels are left as said: a gap is no part of a convex set. */
static void sets_with_gaps_are_not_convex(void **unused)
{
    (void)unused;
    static const int32_t unary[4] = {3, 2, 1, 0};
    static const struct {
        uint8_t kept[4];
        bool convex;
    } cases[] = {
        {{1, 1, 1, 1}, true},  {{0, 1, 1, 0}, true},  {{1, 0, 1, 1}, false},
        {{1, 0, 0, 1}, false}, {{0, 1, 0, 1}, false}, {{0, 0, 1, 0}, true},
    };
    qs_model model = {.sites = 1, .labels = 4, .unary = unary};
    assert_true(qs_unary_is_convex(&model));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        model.kept = cases[i].kept;
        assert_int_equal(qs_unary_is_convex(&model), cases[i].convex);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_unary_costs),
        cmocka_unit_test(convex_unary_costs),
        cmocka_unit_test(labels_left),
        cmocka_unit_test(stopped_by_a_watch),
        cmocka_unit_test(limit_of_iterations),
        cmocka_unit_test(refusals),
        cmocka_unit_test(large_costs),
        cmocka_unit_test(both_agree),
        cmocka_unit_test(sets_with_gaps_are_not_convex),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
