/* Solvers in numbers of 64 bits: the same answers as in 32, and right ones where costs are too
 * large for these. */
#include "tiny.h"

#include <string.h>

#include "reduce/hand_over.h"
#include "solve/fusion.h"
#include "solve/messages.h"
#include "solve/solve_64.h"

enum { ROUNDS = 300, BITS = 12, MEMORY = 1 << 16 };

static tiny t;
static uint64_t model_memory[MEMORY / 8], memory[MEMORY / 8];
static qs_model model;

static void build(void)
{
    size_t size = qs_model_of_problem_workspace(&t.problem);
    assert_true(size <= sizeof model_memory);
    assert_int_equal(qs_model_of_problem(&t.problem, model_memory, size, &model, NULL), QS_OK);
}

typedef struct pair {
    qs_solver *solve, *solve_64;
    size_t (*workspace)(const qs_model *), (*workspace_64)(const qs_model *);
} pair;

static const pair solvers[] = {
    {qs_trws, qs_trws_64, qs_trws_workspace, qs_trws_workspace_64},
    {qs_bp, qs_bp_64, qs_bp_workspace, qs_bp_workspace_64},
    {qs_expansion, qs_expansion_64, qs_expansion_workspace, qs_expansion_workspace_64},
    {qs_swap, qs_swap_64, qs_swap_workspace, qs_swap_workspace_64},
    {qs_min_cut, qs_min_cut_64, qs_min_cut_workspace, qs_min_cut_workspace_64},
    {qs_best, qs_best_64, qs_best_workspace, qs_best_workspace_64},
};
enum { SOLVERS = sizeof solvers / sizeof *solvers };

/* Runs a solver in exactly the memory that it asks for, and checks what must hold of any answer. */
static qs_status run(qs_solver *solve, size_t size, uint16_t *labelling, qs_solution *s)
{
    assert_true(size <= sizeof memory);
    memset(memory, 0xa5, sizeof memory);
    qs_model_winner(&model, labelling);
    qs_status status = solve(&model, NULL, memory, size, labelling, s);
    for (size_t i = size; i < sizeof memory; i++) {
        assert_int_equal(((uint8_t *)memory)[i], 0xa5);
    }
    if (status == QS_OK) {
        assert_int_equal(s->energy, qs_model_energy(&model, labelling));
    }
    return status;
}

static void the_same_in_both(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    for (int round = 0; round < ROUNDS; round++) {
        tiny_make(&t, &state, BITS, false);
        build();
        assert_true(qs_messages_fit(&model, true) && qs_fusion_fits(&model));
        for (size_t i = 0; i < SOLVERS; i++) {
            const pair *by = &solvers[i];
            uint16_t narrow[TINY_SITES], wide[TINY_SITES];
            qs_solution a, b;
            qs_status status = run(by->solve, by->workspace(&model), narrow, &a);
            assert_int_equal(run(by->solve_64, by->workspace_64(&model), wide, &b), status);
            if (status == QS_OK) {
                assert_memory_equal(narrow, wide, sizeof *narrow * model.sites);
                assert_int_equal(a.energy, b.energy);
                assert_int_equal(a.lower_bound, b.lower_bound);
                assert_int_equal(a.iterations, b.iterations);
            }
        }
    }
}

/* Makes all costs of a problem larger, in proportion: the largest comes to 2^(30 - less), about. */
static void enlarge(uint32_t less)
{
    qs_problem *p = &t.problem;
    uint32_t sites = qs_problem_sites(p);
    int32_t largest = p->weight > 0 ? p->weight : 1;
    for (uint32_t i = 0; i < sites * p->labels; i++) {
        largest = t.costs[i] > largest ? t.costs[i] : largest;
        largest = -t.costs[i] > largest ? -t.costs[i] : largest;
    }
    for (int i = 0; i < TINY_SITES; i++) {
        largest = t.right[i] > largest ? t.right[i] : largest;
        largest = t.down[i] > largest ? t.down[i] : largest;
    }
    for (uint64_t i = 0; i < p->edge_count; i++) {
        largest = t.edges[i].weight > largest ? t.edges[i].weight : largest;
    }
    int32_t times = INT32_MAX / 2 / largest >> less;
    for (uint32_t i = 0; i < sites * p->labels; i++) {
        t.costs[i] *= times;
    }
    for (int i = 0; i < TINY_SITES; i++) {
        t.right[i] *= times;
        t.down[i] *= times;
    }
    for (uint64_t i = 0; i < p->edge_count; i++) {
        t.edges[i].weight *= times;
    }
    p->weight *= times;
}

/* The same problem with small costs and with large ones: what was proven is proven again. */
static void large_costs(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    uint32_t large = 0, proven[SOLVERS] = {0}, before[SOLVERS] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        qs_solution small[SOLVERS], s;
        bool solved[SOLVERS];
        uint16_t labelling[TINY_SITES];
        tiny_make(&t, &state, BITS, false);
        build();
        for (size_t i = 0; i < SOLVERS; i++) {
            solved[i] =
                run(solvers[i].solve, solvers[i].workspace(&model), labelling, &small[i]) == QS_OK;
        }
        enlarge(tiny_random(&state, 3));
        build();
        int64_t minimum = tiny_minimum(&t.problem);
        large += !qs_messages_fit(&model, false);
        for (size_t i = 0; i < SOLVERS; i++) {
            if (!solved[i]) {
                continue;
            }
            assert_int_equal(run(solvers[i].solve, solvers[i].workspace(&model), labelling, &s),
                             QS_OK);
            assert_true(s.energy >= minimum);
            if (s.lower_bound != QS_NO_BOUND) {
                assert_true(s.lower_bound <= minimum);
                before[i] += small[i].energy == small[i].lower_bound;
                proven[i] += s.energy == s.lower_bound;
            }
        }
    }
    assert_true(large > ROUNDS / 8);
    for (size_t i = 0; i < SOLVERS; i++) {
        assert_true(proven[i] >= before[i]);
    }
}

typedef qs_status reducer(const qs_model *model, const qs_reduce_options *options, void *workspace,
                          size_t size, uint8_t *kept, uint16_t *labelling, qs_reduction *reduction);

static uint8_t kept[TINY_SITES * TINY_LABELS];

static qs_reduction reduce(reducer *by, size_t size)
{
    uint16_t labelling[TINY_SITES];
    qs_reduction r;
    assert_true(size <= sizeof memory);
    memset(memory, 0xa5, sizeof memory);
    memset(kept, 0xa5, sizeof kept);
    assert_int_equal(by(&model, NULL, memory, size, kept, labelling, &r), QS_OK);
    assert_int_equal(r.upper_bound, qs_model_energy(&model, labelling));
    return r;
}

/* The least energy of all labellings of kept labels. */
static int64_t minimum_of_kept(void)
{
    uint16_t x[TINY_SITES] = {0};
    int64_t least = INT64_MAX;
    for (uint32_t p = 0; p < model.sites;) {
        bool all = true;
        for (uint32_t q = 0; q < model.sites; q++) {
            all = all && kept[q * model.labels + x[q]];
        }
        int64_t energy = all ? qs_model_energy(&model, x) : INT64_MAX;
        least = energy < least ? energy : least;
        for (p = 0; p < model.sites && ++x[p] == model.labels; p++) {
            x[p] = 0;
        }
    }
    return least;
}

/* The optimum stays, and as many sites are decided as with small costs, but for a few: an edge that
 * costs more than a unary cost can hold is not folded into it. */
static void large_costs_reduce(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    uint32_t large = 0, undecided = 0, before = 0;
    for (int round = 0; round < ROUNDS; round++) {
        tiny_make(&t, &state, BITS - 2, false);
        build();
        qs_reduction small = reduce(qs_reduce, qs_reduce_workspace(&model));
        uint8_t narrow[sizeof kept];
        memcpy(narrow, kept, sizeof kept);
        qs_reduction same = reduce(qs_reduce_64, qs_reduce_workspace_64(&model));
        assert_memory_equal(narrow, kept, (size_t)model.sites * model.labels);
        assert_int_equal(small.upper_bound, same.upper_bound);
        assert_int_equal(small.lower_bound, same.lower_bound);
        assert_int_equal(small.iterations, same.iterations);
        enlarge(tiny_random(&state, 3));
        build();
        large += !qs_messages_fit(&model, true);
        qs_reduction r = reduce(qs_reduce, qs_reduce_workspace(&model));
        int64_t minimum = tiny_minimum(&t.problem);
        assert_int_equal(minimum_of_kept(), minimum);
        assert_true(r.lower_bound <= minimum && r.upper_bound >= minimum);
        undecided += r.undecided;
        before += small.undecided;
    }
    assert_true(large > ROUNDS / 8);
    assert_true(undecided <= before + ROUNDS / 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_in_both),
        cmocka_unit_test(large_costs),
        cmocka_unit_test(large_costs_reduce),
    };
    return cmocka_run_group_tests_name("64 bits", tests, NULL, NULL);
}
