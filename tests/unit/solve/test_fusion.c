/* Fusion moves against all choices of tiny problems. */
#include "slow.h"

#include <string.h>

#include "solve/fusion.h"

enum { ROUNDS = 3000, BITS = 24, MEMORY = 1 << 16 };

static tiny t;
static slow_request request;
static slow_qubo qubo;
static uint64_t model_memory[MEMORY / 8], memory[MEMORY / 8];
static qs_model model;

static void make(uint64_t *state, bool all)
{
    tiny_make(&t, state, BITS, false);
    request = (slow_request){.problem = &t.problem, .encoding = QS_ONE_HOT, .gap = 1};
    if (all) {
        memset(request.kept, 1, sizeof request.kept);
    } else {
        slow_choose_labels(&request, state);
    }
    slow_encode(&request, &qubo);
    assert_int_equal(qs_model_build(&qubo.index, model_memory, sizeof model_memory, &model), QS_OK);
}

/* The weight of the edge of two sites, p < q; 0 = there is none. */
static int64_t weight_of(uint32_t p, uint32_t q)
{
    if (model.width > 0) {
        return q == p + 1 && model.right[p] > 0 ? model.right[p]
               : q == p + model.width           ? model.down[p]
                                                : 0;
    }
    for (uint32_t n = model.link_start[p]; n < model.link_start[p + 1]; n++) {
        if (model.links[n].site == q) {
            return model.links[n].weight;
        }
    }
    return 0;
}

static int64_t pair(uint16_t a, uint16_t c)
{
    return qs_model_pairwise(&model, a, c);
}

/* The energy of a choice as the cut has it: of sites that both may change, and both keep their
 * labels, an edge may count as less. */
static int64_t cut_energy(const uint16_t *x, const uint16_t *to, uint32_t choice)
{
    uint16_t labelling[TINY_SITES];
    int64_t less = 0;
    for (uint32_t p = 0; p < model.sites; p++) {
        labelling[p] = choice >> p & 1 ? to[p] : x[p];
        for (uint32_t q = p + 1; q < model.sites; q++) {
            int64_t weight = weight_of(p, q);
            if (weight > 0 && x[p] != to[p] && x[q] != to[q] && (choice >> p & 1) == 0 &&
                (choice >> q & 1) == 0) {
                int64_t more =
                    pair(x[p], x[q]) + pair(to[p], to[q]) - pair(x[p], to[q]) - pair(to[p], x[q]);
                less += more > 0 ? weight * more : 0;
            }
        }
    }
    return qs_model_energy(&model, labelling) - less;
}

static int64_t least_cut(const uint16_t *x, const uint16_t *to)
{
    int64_t least = INT64_MAX;
    for (uint32_t choice = 0; choice < 1u << model.sites; choice++) {
        int64_t energy = cut_energy(x, to, choice);
        least = energy < least ? energy : least;
    }
    return least;
}

/* The choice that made `after` of `before`. */
static uint32_t choice_of(const uint16_t *before, const uint16_t *after)
{
    uint32_t choice = 0;
    for (uint32_t p = 0; p < model.sites; p++) {
        choice |= (uint32_t)(after[p] != before[p]) << p;
    }
    return choice;
}

static void begin(qs_fusion *fusion, uint16_t *labelling)
{
    qs_arena arena = {.base = (char *)memory};
    memset(memory, 0xa5, sizeof memory);
    *fusion = (qs_fusion){.m = {.model = &model, .x = labelling}};
    qs_fusion_take(fusion, &arena);
    assert_true(qs_arena_size(&arena) <= sizeof memory);
    assert_true(qs_fusion_fits(&model));
    qs_fusion_start(fusion);
}

/* Never a rise, each site with one of its two labels; the best choice that the cut can see. */
static void moves_are_choices(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    int exacts = 0, gains = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t before[TINY_SITES], x[TINY_SITES], proposal[TINY_SITES];
        qs_fusion fusion;
        qs_solution solution = {0};
        int64_t gain;
        make(&state, round % 2 == 0);
        slow_random_labels(&model, &state, before);
        slow_random_labels(&model, &state, proposal);
        memcpy(x, before, sizeof x);
        begin(&fusion, x);
        fusion.solution = &solution;
        memcpy(fusion.proposal, proposal, sizeof *proposal * model.sites);
        assert_true(qs_fuse(&fusion, &gain));
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_true(x[p] == before[p] || x[p] == proposal[p]);
        }
        int64_t energy = qs_model_energy(&model, x);
        assert_true(gain >= 0);
        assert_int_equal(qs_model_energy(&model, before) - energy, gain);
        assert_int_equal(fusion.m.energy, energy);
        int64_t keep = cut_energy(before, proposal, 0);
        bool exact = keep == energy + gain; /* no edge counted as less */
        exacts += exact;
        gains += gain > 0;
        if (gain > 0 || exact) {
            assert_int_equal(cut_energy(before, proposal, choice_of(before, x)),
                             least_cut(before, proposal));
        }
        if (gain == 0) {
            assert_memory_equal(x, before, sizeof *x * model.sites);
        }
    }
    assert_true(exacts > ROUNDS / 4 && exacts < ROUNDS * 9 / 10);
    assert_true(gains > ROUNDS / 4);
}

/* A proposal of labels that are not left changes nothing. */
static void labels_that_are_out_are_not_taken(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t x[TINY_SITES];
        qs_fusion fusion;
        qs_solution solution = {0};
        int64_t gain;
        make(&state, false);
        slow_random_labels(&model, &state, x);
        begin(&fusion, x);
        fusion.solution = &solution;
        for (uint32_t p = 0; p < model.sites; p++) {
            fusion.proposal[p] = (uint16_t)tiny_random(&state, model.labels);
        }
        assert_true(qs_fuse(&fusion, &gain));
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_true(slow_is_kept(&model, p, x[p]));
        }
    }
}

/* Moves end: no jump gains, and no label for all. Each of them is tried as a proposal. */
static void moves_end(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    const int32_t jumps[] = {1, -1, 2, -2, 3, -3, 4, -4};
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t x[TINY_SITES];
        qs_fusion fusion;
        qs_solution s, solution = {0};
        make(&state, round % 2 == 0);
        slow_random_labels(&model, &state, x);
        int64_t before = qs_model_energy(&model, x), gain;
        assert_int_equal(
            qs_fusion_moves(QS_FUSION_JUMPS, &model, NULL, memory, sizeof memory, x, &s), QS_OK);
        assert_true(s.converged && s.lower_bound == QS_NO_BOUND && s.iterations > 0);
        assert_true(s.energy <= before);
        assert_int_equal(s.energy, qs_model_energy(&model, x));
        begin(&fusion, x);
        fusion.solution = &solution;
        for (uint32_t at = 0; at < 8 + model.labels; at++) {
            for (uint32_t p = 0; p < model.sites; p++) {
                int32_t to = at < 8 ? x[p] + jumps[at] : (int32_t)at - 8;
                fusion.proposal[p] = to >= 0 && to < (int32_t)model.labels ? (uint16_t)to : x[p];
            }
            assert_true(qs_fuse(&fusion, &gain));
            assert_int_equal(gain, 0);
        }
    }
}

static void refusals(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    uint16_t x[TINY_SITES] = {0};
    qs_solution s;
    make(&state, true);
    size_t size = qs_fusion_moves_workspace(&model);
    assert_int_equal(qs_fusion_moves(QS_FUSION_JUMPS, &model, NULL, memory, size - 1, x, &s),
                     QS_E_WORKSPACE);
    assert_int_equal(qs_fusion_moves(QS_FUSION_JUMPS, &model, NULL, memory, size, x, &s), QS_OK);
    static int32_t costs[TINY_SITES * TINY_LABELS];
    memcpy(costs, model.unary, sizeof *costs * model.sites * model.labels);
    costs[0] = INT32_MAX;
    model.unary = costs;
    size_t larger = qs_fusion_moves_workspace(&model);
    assert_true(larger > size && larger <= sizeof memory); /* in 64 bits */
    assert_int_equal(qs_fusion_moves(QS_FUSION_JUMPS, &model, NULL, memory, larger - 1, x, &s),
                     QS_E_WORKSPACE);
    assert_int_equal(qs_fusion_moves(QS_FUSION_JUMPS, &model, NULL, memory, larger, x, &s), QS_OK);
    assert_int_equal(s.energy, qs_model_energy(&model, x));
}

/* 32 bits are enough for costs and edges up to here, and for no more. */
static void range_of_32_bits(void **unused)
{
    (void)unused;
    int32_t costs[4] = {0, INT32_MAX / 4, 0, 0}, right[2] = {(1 << 27) - 1, 0}, down[2] = {0};
    qs_model two = {.sites = 2,
                    .labels = 2,
                    .unary = costs,
                    .pairwise_max = 1,
                    .width = 2,
                    .height = 1,
                    .right = right,
                    .down = down};
    assert_true(qs_fusion_fits(&two));
    costs[1]++;
    assert_false(qs_fusion_fits(&two));
    costs[1]--;
    right[0]++;
    assert_false(qs_fusion_fits(&two));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moves_are_choices), cmocka_unit_test(labels_that_are_out_are_not_taken),
        cmocka_unit_test(moves_end),         cmocka_unit_test(range_of_32_bits),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
