/* Encodings and penalties against all states of tiny problems (docs/MATHS.md). */
#include "tiny.h"

#include <string.h>

enum { ROUNDS = 400, BITS = 12 };

/* All states of an encoded problem: is the least H the least F, is every minimiser feasible, how
 * far above it is the lowest infeasible state, and is every infeasible state improved by some flip?
 */
typedef struct sweep {
    int64_t minimum, feasible_minimum, infeasible_minimum;
    uint32_t stuck; /* infeasible states that no single flip improves */
} sweep;

static bool feasible(const qs_index *index, uint32_t state)
{
    uint8_t bits[4];
    tiny_bits(state, bits);
    return qs_sample_infeasible(index, bits) == 0;
}

static sweep sweep_states(const qs_problem *problem, const tiny_qubo *q, bool sparse)
{
    static int64_t energy[1 << BITS];
    uint32_t variables = q->qubo.variables;
    sweep s = {INT64_MAX, INT64_MAX, INT64_MAX, 0};
    for (uint32_t state = 0; state < 1u << variables; state++) {
        uint8_t bits[4];
        tiny_bits(state, bits);
        energy[state] = qs_qubo_energy(&q->index, bits);
        assert_int_equal(energy[state], tiny_energy(problem, sparse, &q->index, state));
        int64_t *least = feasible(&q->index, state) ? &s.feasible_minimum : &s.infeasible_minimum;
        *least = energy[state] < *least ? energy[state] : *least;
        s.minimum = energy[state] < s.minimum ? energy[state] : s.minimum;
    }
    for (uint32_t state = 0; state < 1u << variables; state++) {
        bool improves = feasible(&q->index, state);
        for (uint32_t i = 0; i < variables && !improves; i++) {
            improves = energy[state ^ 1u << i] < energy[state];
        }
        s.stuck += !improves;
    }
    return s;
}

/* H = F on every feasible state, by way of decoding and encoding the sample. */
static void feasible_states_agree(const qs_problem *problem, const tiny_qubo *q)
{
    for (uint32_t state = 0; state < 1u << q->qubo.variables; state++) {
        uint8_t bits[4], again[4] = {0};
        uint16_t labelling[TINY_SITES];
        int64_t energy;
        tiny_bits(state, bits);
        if (!feasible(&q->index, state)) {
            assert_int_equal(qs_sample_decode(&q->index, bits, labelling), QS_E_INFEASIBLE);
            continue;
        }
        assert_int_equal(qs_sample_decode(&q->index, bits, labelling), QS_OK);
        assert_int_equal(qs_problem_energy(problem, labelling, NULL, 0, &energy), QS_OK);
        assert_int_equal(energy, qs_qubo_energy(&q->index, bits));
        assert_int_equal(qs_sample_encode(&q->index, labelling, again), QS_OK);
        assert_memory_equal(bits, again, (q->qubo.variables + 7) / 8);
    }
}

static void repair_never_raises(const tiny_qubo *q, int64_t gap)
{
    for (uint32_t state = 0; state < 1u << q->qubo.variables; state++) {
        uint8_t bits[4];
        tiny_bits(state, bits);
        int64_t before = qs_qubo_energy(&q->index, bits);
        uint32_t changed;
        assert_int_equal(qs_sample_repair(&q->index, bits, NULL, 0, &changed), QS_OK);
        int64_t after = qs_qubo_energy(&q->index, bits);
        assert_int_equal(qs_sample_infeasible(&q->index, bits), 0);
        assert_int_equal(changed > 0, !feasible(&q->index, state));
        assert_true(changed == 0 ? after == before : after <= before - gap);
    }
}

static void proven_penalty(const tiny *t, qs_encoding encoding, qs_penalty penalty, uint32_t gap)
{
    static tiny_qubo q;
    tiny_encode(&t->problem, (qs_encode_options){encoding, penalty, 0, gap}, &q);
    sweep s = sweep_states(&t->problem, &q, encoding == QS_ONE_HOT_SPARSE);
    assert_int_equal(s.minimum, tiny_minimum(&t->problem));
    assert_int_equal(s.minimum, s.feasible_minimum);
    assert_true(s.infeasible_minimum >= s.minimum + gap);
    assert_int_equal(s.stuck, 0);
    feasible_states_agree(&t->problem, &q);
    repair_never_raises(&q, gap);
}

static void one_hot_local(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    for (int round = 0; round < ROUNDS; round++) {
        tiny t;
        tiny_make(&t, &state, BITS, false);
        proven_penalty(&t, QS_ONE_HOT, QS_PENALTY_LOCAL, 1 + tiny_random(&state, 3));
    }
}

static void one_hot_paper(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    for (int round = 0; round < ROUNDS; round++) {
        tiny t;
        tiny_make(&t, &state, BITS, false);
        proven_penalty(&t, QS_ONE_HOT, QS_PENALTY_PAPER, 1);
    }
}

static void sparse_local(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    for (int round = 0; round < ROUNDS; round++) {
        tiny t;
        tiny_make(&t, &state, BITS, true);
        proven_penalty(&t, QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL, 1 + tiny_random(&state, 3));
    }
}

static void sparse_paper(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    for (int round = 0; round < ROUNDS; round++) {
        tiny t;
        tiny_make(&t, &state, BITS, true);
        proven_penalty(&t, QS_ONE_HOT_SPARSE, QS_PENALTY_PAPER, 1);
    }
}

/* A star K(1,n): the centre is site 0. Forced labels have cost 0, all others `high`. */
static qs_problem star(tiny *t, uint32_t leaves, uint32_t labels, int32_t weight)
{
    memset(t, 0, sizeof *t);
    for (uint32_t e = 0; e < leaves; e++) {
        t->edges[e] = (qs_edge){0, e + 1, weight};
    }
    t->problem = (qs_problem){.sites = leaves + 1,
                              .labels = labels,
                              .scale = 1,
                              .edges = t->edges,
                              .edge_count = leaves,
                              .costs = t->costs};
    return t->problem;
}

static void force(tiny *t, uint32_t site, uint32_t label)
{
    for (uint32_t d = 0; d < t->problem.labels; d++) {
        t->costs[site * t->problem.labels + d] = d == label ? 0 : 100000;
    }
}

/* min over infeasible states less min over feasible ones. */
static int64_t margin(const qs_problem *problem, qs_encode_options options)
{
    static tiny_qubo q;
    tiny_encode(problem, options, &q);
    sweep s = sweep_states(problem, &q, options.encoding == QS_ONE_HOT_SPARSE);
    return s.infeasible_minimum - s.feasible_minimum;
}

/* MATHS: K(1,4), weight 100, W = 400, the centre bound to one label and the leaves to another:
 * leaving the centre empty costs a. */
static void one_hot_bound_is_tight(void **unused)
{
    (void)unused;
    tiny t;
    star(&t, 4, 2, 100);
    force(&t, 0, 0);
    for (uint32_t leaf = 1; leaf <= 4; leaf++) {
        force(&t, leaf, 1);
    }
    for (int64_t alpha = 399; alpha <= 401; alpha++) {
        assert_int_equal(
            margin(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_GIVEN, alpha, 0}),
            alpha - 400);
    }
    assert_int_equal(margin(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 7}),
                     7);
}

/* MATHS: the centre of K(1,4) is free in two labels, two leaves are bound to each: the centre with
 * both at 1 costs b - a, against W/2. */
static void sparse_bound_is_tight(void **unused)
{
    (void)unused;
    tiny t;
    star(&t, 4, 2, 100);
    for (uint32_t leaf = 1; leaf <= 4; leaf++) {
        force(&t, leaf, leaf > 2);
    }
    for (int64_t alpha = 199; alpha <= 201; alpha++) {
        assert_int_equal(
            margin(&t.problem, (qs_encode_options){QS_ONE_HOT_SPARSE, QS_PENALTY_GIVEN, alpha, 0}),
            alpha - 200);
    }
}

/* The penalties are those of the theorems, site for site: 3 x 2 grid, lambda 5, W = 10, 15, 10. */
static void local_values(void **unused)
{
    (void)unused;
    static tiny_qubo q;
    tiny t = {0};
    t.problem = (qs_problem){
        .labels = 2, .scale = 1, .weight = 5, .grid = {.width = 3, .height = 2}, .costs = t.costs};
    const int64_t reach[6] = {10, 15, 10, 10, 15, 10};
    for (uint32_t gap = 1; gap <= 4; gap += 3) {
        for (uint32_t g = 0; g < 6; g++) {
            int64_t a, b;
            tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, gap}, &q);
            qs_index_penalty(&q.index, g, &a, &b);
            assert_int_equal(a, reach[g] + gap);
            assert_int_equal(b, a + gap);
            tiny_encode(&t.problem,
                        (qs_encode_options){QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL, 0, gap}, &q);
            qs_index_penalty(&q.index, g, &a, &b);
            assert_int_equal(a, gap);
            assert_int_equal(b, a + reach[g] + gap);
        }
    }
}

/* The least integer above sum max theta + lambda |N|, of the costs as given: 4 x (9 + 3) + 4 edges
 * x 5. */
static void paper_value(void **unused)
{
    (void)unused;
    static tiny_qubo q;
    tiny t = {0};
    for (int i = 0; i < 8; i++) {
        t.costs[i] = i % 2 ? 12 : 3;
    }
    t.problem = (qs_problem){
        .labels = 2, .scale = 1, .weight = 5, .grid = {.width = 2, .height = 2}, .costs = t.costs};
    tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_PAPER, 0, 0}, &q);
    int64_t a, b;
    qs_index_penalty(&q.index, 0, &a, &b);
    assert_int_equal(a, 4 * 12 + 4 * 5 + 1);
    assert_int_equal(b, 2 * a);
    assert_int_equal(q.qubo.offset, 4 * 3);
}

/* The summary beside all terms of the naive matrix: H of one and of two variables at 1. */
static void summary_counts_all_terms(void **unused)
{
    (void)unused;
    static tiny_qubo q;
    uint64_t state = 5;
    for (int round = 0; round < ROUNDS; round++) {
        tiny t;
        tiny_make(&t, &state, BITS, round % 2 == 0);
        bool sparse = round % 4 == 0;
        tiny_encode(
            &t.problem,
            (qs_encode_options){sparse ? QS_ONE_HOT_SPARSE : QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 0},
            &q);
        int64_t none = tiny_energy(&t.problem, sparse, &q.index, 0), linear[BITS];
        qs_qubo_summary expected = {.offset = none,
                                    .linear_min = INT64_MAX,
                                    .linear_max = INT64_MIN},
                        got;
        for (uint32_t i = 0; i < q.qubo.variables; i++) {
            linear[i] = tiny_energy(&t.problem, sparse, &q.index, 1u << i) - none;
            expected.linear_min = linear[i] < expected.linear_min ? linear[i] : expected.linear_min;
            expected.linear_max = linear[i] > expected.linear_max ? linear[i] : expected.linear_max;
            for (uint32_t j = 0; j < i; j++) {
                int64_t both = tiny_energy(&t.problem, sparse, &q.index, 1u << i | 1u << j) - none -
                               linear[i] - linear[j];
                if (both != 0) {
                    bool first = expected.quadratic_terms++ == 0;
                    expected.quadratic_min =
                        first || both < expected.quadratic_min ? both : expected.quadratic_min;
                    expected.quadratic_max =
                        first || both > expected.quadratic_max ? both : expected.quadratic_max;
                }
            }
        }
        qs_qubo_summarise(&q.qubo, &got);
        assert_int_equal(got.quadratic_terms, expected.quadratic_terms);
        assert_int_equal(got.offset, expected.offset);
        assert_int_equal(got.linear_min, expected.linear_min);
        assert_int_equal(got.linear_max, expected.linear_max);
        assert_int_equal(got.quadratic_min, expected.quadratic_min);
        assert_int_equal(got.quadratic_max, expected.quadratic_max);
    }
}

static void pairwise_costs(void **unused)
{
    (void)unused;
    const int32_t table[4] = {0, 5, 7, 1};
    static const struct {
        qs_smoothness smoothness;
        uint32_t truncation, a, b;
        int64_t cost;
    } cases[] = {
        {QS_POTTS, 0, 3, 3, 0},
        {QS_POTTS, 9, 0, 9, 1},
        {QS_TRUNCATED_LINEAR, 0, 2, 9, 7},
        {QS_TRUNCATED_LINEAR, 3, 9, 2, 3},
        {QS_TRUNCATED_LINEAR, 3, 4, 2, 2},
        {QS_TRUNCATED_QUADRATIC, 0, 0, 65534, 4294705156},
        {QS_TRUNCATED_QUADRATIC, 10, 1, 4, 9},
        {QS_TRUNCATED_QUADRATIC, 10, 5, 1, 10},
        {QS_TABLE, 0, 0, 1, 5},
        {QS_TABLE, 0, 1, 0, 7},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        qs_problem p = {.labels = 2, .pairwise = {cases[i].smoothness, cases[i].truncation, table}};
        assert_int_equal(qs_pairwise_cost(&p, cases[i].a, cases[i].b), cases[i].cost);
    }
}

/* A mask that masks nothing, and weights that are all the same, are the same problem: the same
 * bytes. */
static void one_problem_one_string(void **unused)
{
    (void)unused;
    static tiny_qubo plain, dressed;
    tiny t = {0};
    t.problem = (qs_problem){
        .labels = 3, .scale = 1, .weight = 4, .grid = {.width = 4, .height = 3}, .costs = t.costs};
    tiny_encode(&t.problem, (qs_encode_options){0}, &plain);
    memset(t.mask, 1, sizeof t.mask);
    for (int i = 0; i < 12; i++) {
        t.right[i] = t.down[i] = 4;
    }
    t.problem.grid.mask = t.mask;
    t.problem.grid.right = t.right;
    t.problem.grid.down = t.down;
    tiny_encode(&t.problem, (qs_encode_options){0}, &dressed);
    assert_int_equal(plain.size, dressed.size);
    assert_memory_equal(plain.file, dressed.file, plain.size);
}

static qs_status encode_status(const qs_problem *problem, qs_encode_options options)
{
    static uint64_t memory[1 << 17];
    return qs_encode(problem, &options, NULL, memory, sizeof memory, NULL);
}

static void refusals(void **unused)
{
    (void)unused;
    tiny t = {0};
    t.problem = (qs_problem){
        .labels = 3, .scale = 1, .weight = 4, .grid = {.width = 4, .height = 3}, .costs = t.costs};
    qs_problem p = t.problem;
    p.pairwise.smoothness = QS_TRUNCATED_QUADRATIC;
    assert_int_equal(encode_status(&p, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE}),
                     QS_E_ENCODING);
    p.pairwise.smoothness = QS_TRUNCATED_LINEAR;
    assert_int_equal(encode_status(&p, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE}), QS_OK);
    assert_int_equal(encode_status(&p, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE,
                                                           .penalty = QS_PENALTY_PAPER}),
                     QS_E_ENCODING);
    assert_int_equal(encode_status(&t.problem, (qs_encode_options){.encoding = QS_DOMAIN_WALL}),
                     QS_E_ENCODING);
    assert_int_equal(encode_status(&t.problem, (qs_encode_options){.encoding = QS_ST_CUT_ARCS + 1}),
                     QS_E_ARGUMENT);
    assert_int_equal(
        encode_status(&t.problem, (qs_encode_options){.penalty = QS_PENALTY_MINIMAL + 1}),
        QS_E_ARGUMENT);
    p = t.problem;
    p.weight = -1;
    assert_int_equal(encode_status(&p, (qs_encode_options){0}), QS_E_ARGUMENT);
    p = t.problem;
    p.labels = QS_LABELS_MAX;
    p.grid = (qs_grid){.width = 40000, .height = 1};
    assert_int_equal(encode_status(&p, (qs_encode_options){0}), QS_E_LIMIT);
    p = t.problem;
    assert_int_equal(
        encode_status(&p, (qs_encode_options){.penalty = QS_PENALTY_GIVEN, .alpha = 0}),
        QS_E_ARGUMENT);
    assert_int_equal(
        encode_status(&p, (qs_encode_options){.penalty = QS_PENALTY_GIVEN, .alpha = INT64_MAX}),
        QS_E_OVERFLOW);
    assert_int_equal(encode_status(&p, (qs_encode_options){.penalty = QS_PENALTY_GIVEN,
                                                           .alpha = (int64_t)1 << 50}),
                     QS_E_OVERFLOW);
    p.labels = 100000;
    assert_int_equal(encode_status(&p, (qs_encode_options){0}), QS_E_ARGUMENT);
    /* A quadratic cost of 65,534^2 does not fit a block's entry. */
    static int32_t wide[2 * QS_LABELS_MAX];
    p = (qs_problem){.labels = QS_LABELS_MAX,
                     .scale = 1,
                     .weight = 1,
                     .grid = {.width = 2, .height = 1},
                     .costs = wide};
    p.pairwise.smoothness = QS_TRUNCATED_QUADRATIC;
    assert_int_equal(encode_status(&p, (qs_encode_options){0}), QS_E_OVERFLOW);
    p = t.problem;
    assert_int_equal(qs_encode(&p, &(qs_encode_options){0}, NULL, t.mask, 1, NULL), QS_E_WORKSPACE);
}

/* A sink that takes `left` more calls. */
static bool failing_write(void *context, const void *bytes, size_t size)
{
    (void)bytes;
    (void)size;
    return (*(int *)context)-- > 0;
}

static void every_failing_write_is_told(void **unused)
{
    (void)unused;
    static uint64_t memory[8192];
    tiny t = {0};
    t.problem = (qs_problem){
        .labels = 3, .scale = 1, .weight = 4, .grid = {.width = 4, .height = 3}, .costs = t.costs};
    int calls = 0;
    for (qs_status status = QS_E_IO; status != QS_OK; calls++) {
        int left = calls;
        qs_sink sink = {failing_write, &left};
        status = qs_encode(&t.problem, &(qs_encode_options){0}, &sink, memory, sizeof memory, NULL);
        assert_true(status == QS_E_IO || status == QS_OK);
        assert_true(calls < 1000);
    }
    assert_true(calls > 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_hot_local),
        cmocka_unit_test(one_hot_paper),
        cmocka_unit_test(sparse_local),
        cmocka_unit_test(sparse_paper),
        cmocka_unit_test(one_hot_bound_is_tight),
        cmocka_unit_test(sparse_bound_is_tight),
        cmocka_unit_test(local_values),
        cmocka_unit_test(paper_value),
        cmocka_unit_test(summary_counts_all_terms),
        cmocka_unit_test(pairwise_costs),
        cmocka_unit_test(one_problem_one_string),
        cmocka_unit_test(refusals),
        cmocka_unit_test(every_failing_write_is_told),
    };
    return cmocka_run_group_tests_name("encode", tests, NULL, NULL);
}
