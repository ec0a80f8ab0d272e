/* Packing: the optimum beside all states, bounds when it is stopped, and what it refuses. */
#include "tiny.h"

#include <stdlib.h>
#include <string.h>

#include "solve/pack.h"

enum { SITES = 14 };

/* A random list of edges whose table has no advantage for equal labels. */
static qs_problem make(uint64_t *state, qs_edge *edges, int32_t *costs, int32_t table[4],
                       uint32_t density)
{
    size_t count = 0;
    for (uint32_t p = 0; p < SITES; p++) {
        costs[2 * p] = (int32_t)tiny_random(state, 30);
        costs[2 * p + 1] = (int32_t)tiny_random(state, 30) - 30;
        for (uint32_t q = p + 1; q < SITES; q++) {
            if (tiny_random(state, 100) < density) {
                edges[count++] = (qs_edge){p, q, (int32_t)tiny_random(state, 25)};
            }
        }
    }
    table[1] = (int32_t)tiny_random(state, 3);
    table[2] = (int32_t)tiny_random(state, 3);
    table[0] = (int32_t)tiny_random(state, 3);
    table[3] = table[1] + table[2] + (int32_t)tiny_random(state, 2);
    return (qs_problem){.sites = SITES,
                        .labels = 2,
                        .scale = 1,
                        .pairwise = {QS_TABLE, 0, table},
                        .edges = edges,
                        .edge_count = count,
                        .costs = costs};
}

static int64_t energy_of(const qs_problem *problem, uint32_t bits)
{
    uint16_t labelling[SITES];
    int64_t energy;
    for (uint32_t p = 0; p < SITES; p++) {
        labelling[p] = bits >> p & 1;
    }
    assert_int_equal(qs_problem_energy(problem, labelling, NULL, 0, &energy), QS_OK);
    return energy;
}

static int64_t minimum(const qs_problem *problem)
{
    int64_t least = INT64_MAX;
    for (uint32_t bits = 0; bits < 1u << SITES; bits++) {
        int64_t energy = energy_of(problem, bits);
        least = energy < least ? energy : least;
    }
    return least;
}

static void check(const qs_model *model, const qs_problem *problem, qs_solver *solver,
                  size_t (*workspace)(const qs_model *), uint64_t iterations)
{
    uint16_t labelling[SITES] = {0};
    int64_t energy, least = minimum(problem);
    qs_solution found;
    size_t size = workspace(model);
    void *memory = malloc(size);
    const qs_solve_options options = {.iterations = iterations};
    assert_int_equal(solver(model, &options, memory, size - 1, labelling, &found), QS_E_WORKSPACE);
    assert_int_equal(solver(model, &options, memory, size, labelling, &found), QS_OK);
    assert_int_equal(qs_problem_energy(problem, labelling, NULL, 0, &energy), QS_OK);
    assert_int_equal(energy, found.energy);
    assert_true(found.lower_bound <= least && least <= found.energy);
    if (iterations == 0) {
        assert_int_equal(found.energy, least);
        assert_int_equal(found.lower_bound, least);
        assert_true(found.converged);
    }
    free(memory);
}

static void finds_the_optimum(void **unused)
{
    (void)unused;
    static uint64_t memory[4096];
    uint64_t state = 1;
    for (uint32_t round = 0; round < 60; round++) {
        qs_edge edges[SITES * SITES];
        int32_t costs[2 * SITES], table[4];
        qs_problem p = make(&state, edges, costs, table, round % 5 * 25);
        qs_model model;
        p.edges = p.edge_count > 0 ? edges : NULL;
        assert_true(qs_model_of_problem_workspace(&p) <= sizeof memory);
        assert_int_equal(qs_model_of_problem(&p, memory, sizeof memory, &model, NULL), QS_OK);
        assert_true(qs_can_pack(&model));
        check(&model, &p, qs_pack, qs_pack_workspace, 0);
        check(&model, &p, qs_best, qs_best_workspace, 0);
        check(&model, &p, qs_pack, qs_pack_workspace, 1 + round % 3);
    }
}

/* Many sites that exclude each other by threes: no search could go through their states. */
static void cliques_need_no_search(void **unused)
{
    (void)unused;
    enum { MANY = 300 };
    static qs_edge edges[MANY];
    static int32_t costs[2 * MANY];
    static uint16_t labelling[MANY];
    const int32_t table[4] = {0, 0, 0, 1};
    int64_t expected = 0;
    for (uint32_t p = 0; p < MANY; p += 3) {
        for (uint32_t i = 0; i < 3; i++) {
            costs[2 * (p + i) + 1] = -(int32_t)(10 + i + p % 7);
            edges[p + i] = (qs_edge){p + i / 2, p + 1 + (i > 0), 50};
        }
        expected -= 12 + p % 7;
    }
    const qs_problem p = {.sites = MANY,
                          .labels = 2,
                          .scale = 1,
                          .pairwise = {QS_TABLE, 0, table},
                          .edges = edges,
                          .edge_count = MANY,
                          .costs = costs};
    qs_model model;
    qs_solution found;
    size_t size = qs_model_of_problem_workspace(&p);
    void *memory = malloc(size);
    assert_int_equal(qs_model_of_problem(&p, memory, size, &model, NULL), QS_OK);
    size_t own = qs_pack_workspace(&model);
    void *workspace = malloc(own);
    assert_int_equal(qs_pack(&model, NULL, workspace, own, labelling, &found), QS_OK);
    assert_int_equal(found.energy, expected);
    assert_int_equal(found.lower_bound, expected);
    assert_true(found.iterations <= 2 * MANY);
    free(workspace);
    free(memory);
}

static void refuses_others(void **unused)
{
    (void)unused;
    static uint64_t memory[8192], workspace[1024];
    uint64_t state = 3;
    qs_edge edges[SITES * SITES];
    int32_t costs[3 * SITES] = {0}, table[9] = {0, 2, 2, 3};
    qs_problem p = make(&state, edges, costs, (int32_t[4]){0}, 50);
    uint16_t labelling[SITES] = {0};
    qs_model model;
    qs_solution found;
    p.pairwise.table = table; /* 0 + 3 < 2 + 2 */
    for (p.labels = 2; p.labels <= 3; p.labels++) {
        assert_int_equal(qs_model_of_problem(&p, memory, sizeof memory, &model, NULL), QS_OK);
        assert_false(qs_can_pack(&model));
        assert_int_equal(qs_pack(&model, NULL, workspace, sizeof workspace, labelling, &found),
                         QS_E_ENCODING);
        memset(table, 0, sizeof table);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_the_optimum),
        cmocka_unit_test(cliques_need_no_search),
        cmocka_unit_test(refuses_others),
    };
    return cmocka_run_group_tests_name("pack", tests, NULL, NULL);
}
