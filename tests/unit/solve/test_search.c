/* What searches for labellings is made of: merging, moves on trees, and kicks, beside all
 * labellings of tiny problems. */
#include "slow.h"
#include "stopping.h"

#include <string.h>

#include "base/random.h"
#include "solve/kicks.h"

enum { ROUNDS = 2000, BITS = 20, MEMORY = 1 << 16 };

static tiny t;
static slow_request request;
static slow_qubo qubo;
static uint64_t model_memory[MEMORY / 8], memory[MEMORY / 8];
static qs_model model;
static uint16_t x[TINY_SITES], y[TINY_SITES];

/* A problem with some of its labels, and two labellings. */
static void make(uint64_t *state)
{
    tiny_make(&t, state, BITS, false);
    request = (slow_request){.problem = &t.problem, .encoding = QS_ONE_HOT, .gap = 1};
    slow_choose_labels(&request, state);
    slow_encode(&request, &qubo);
    assert_int_equal(qs_model_build(&qubo.index, model_memory, sizeof model_memory, &model), QS_OK);
    slow_random_labels(&model, state, x);
    slow_random_labels(&model, state, y);
    memset(memory, 0xa5, sizeof memory);
}

static bool are_joined(uint32_t p, uint32_t q)
{
    if (model.width > 0) {
        return (q == p + 1 && model.right[p] > 0) || (q == p + model.width && model.down[p] > 0);
    }
    for (uint32_t n = model.link_start[p]; n < model.link_start[p + 1]; n++) {
        if (model.links[n].site == q && model.links[n].weight > 0) {
            return true;
        }
    }
    return false;
}

/* Whether two sites that differ and are joined always come from the same labelling. */
static bool is_of_whole_parts(uint32_t choice)
{
    for (uint32_t p = 0; p < model.sites; p++) {
        for (uint32_t q = p + 1; q < model.sites; q++) {
            if (x[p] != y[p] && x[q] != y[q] && are_joined(p, q) &&
                ((choice >> p ^ choice >> q) & 1) != 0) {
                return false;
            }
        }
    }
    return true;
}

/* The least energy of all choices between x and y by whole parts. */
static int64_t best_choice(void)
{
    int64_t least = INT64_MAX;
    for (uint32_t choice = 0; choice < 1u << model.sites; choice++) {
        if (is_of_whole_parts(choice)) {
            uint16_t z[TINY_SITES];
            for (uint32_t p = 0; p < model.sites; p++) {
                z[p] = choice >> p & 1 ? y[p] : x[p];
            }
            int64_t energy = qs_model_energy(&model, z);
            least = energy < least ? energy : least;
        }
    }
    return least;
}

static void merging_takes_the_best_parts(void **unused)
{
    (void)unused;
    uint64_t state = 71;
    uint32_t mixed = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        int64_t before = qs_model_energy(&model, x), other = qs_model_energy(&model, y),
                least = best_choice();
        qs_arena arena = {.base = (char *)memory};
        qs_merger merger;
        qs_merger_take(&merger, &model, &arena);
        assert_true(qs_arena_size(&arena) <= sizeof memory);
        assert_int_equal(before - qs_merge(&merger, x, y), least);
        assert_int_equal(qs_model_energy(&model, x), least);
        mixed += least < before && least < other;
    }
    print_message("better than both: %u of %d\n", mixed, ROUNDS);
    assert_true(mixed > ROUNDS / 20);
}

/* The next labels of kept labels of the sites that the last move was of; false after the last. */
static bool step(const qs_trees *trees, uint16_t *labelling)
{
    for (uint32_t i = 0; i < trees->count; i++) {
        uint32_t p = trees->order[i];
        for (uint16_t d = (uint16_t)(labelling[p] + 1); d < model.labels; d++) {
            if (slow_is_kept(&model, p, d)) {
                labelling[p] = d;
                return true;
            }
        }
        for (labelling[p] = 0; !slow_is_kept(&model, p, labelling[p]); labelling[p]++) {
        }
    }
    return false;
}

/* All labels of the sites of the last move: none is better. */
static void check_move(const qs_trees *trees)
{
    int64_t found = qs_model_energy(&model, x);
    uint16_t z[TINY_SITES];
    memcpy(z, x, sizeof z);
    for (uint32_t i = 0; i < trees->count; i++) {
        uint32_t p = trees->order[i];
        for (z[p] = 0; !slow_is_kept(&model, p, z[p]); z[p]++) {
        }
    }
    do {
        assert_true(qs_model_energy(&model, z) >= found);
    } while (step(trees, z));
}

static void moves_on_trees_are_exact(void **unused)
{
    (void)unused;
    uint64_t state = 72, random = 5;
    uint32_t moved = 0, sites = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        qs_arena arena = {.base = (char *)memory};
        qs_trees trees;
        qs_trees_take(&trees, &model, &arena);
        assert_true(qs_arena_size(&arena) <= sizeof memory);
        qs_trees_begin(&trees);
        memcpy(y, x, sizeof y);
        qs_trees_move(&trees, NULL, 0, &random, x);
        check_move(&trees);
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_true(trees.tree[p] == UINT32_MAX); /* no circle has kept a site from its turn */
        }
        moved += trees.count;
        sites += model.sites;
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_true(slow_is_kept(&model, p, x[p]));
        }
    }
    print_message("sites in a forest: %u of %u\n", moved, sites);
    assert_true(moved > sites / 2);
}

static int64_t least_of_all(void)
{
    int64_t least = INT64_MAX;
    qs_trees all = {.order = (uint32_t[TINY_SITES]){0}, .count = model.sites};
    for (uint32_t p = 0; p < model.sites; p++) {
        all.order[p] = p;
        for (y[p] = 0; !slow_is_kept(&model, p, y[p]); y[p]++) {
        }
    }
    do {
        int64_t energy = qs_model_energy(&model, y);
        least = energy < least ? energy : least;
    } while (step(&all, y));
    return least;
}

static void kicks_never_raise(void **unused)
{
    (void)unused;
    enum { FEWER = 400, ROUNDS_MOST = 80 };
    uint64_t state = 73;
    uint32_t solved = 0, sites[TINY_SITES];
    for (int round = 0; round < FEWER; round++) {
        make(&state);
        qs_look look = look_that_stops_after(tiny_random(&state, 200));
        bool patient = tiny_random(&state, 3) > 0;
        size_t size = tiny_random(&state, 9) ? sizeof memory : tiny_random(&state, 200);
        for (uint32_t p = 0; p < model.sites; p++) {
            sites[p] = p;
        }
        int64_t before = qs_model_energy(&model, x);
        qs_kicks kicks = {0};
        int64_t gain = qs_kicks_improve(&kicks, &model, sites, model.sites, ROUNDS_MOST, x, memory,
                                        size, patient ? NULL : &look);
        assert_true(gain >= 0);
        assert_int_equal(qs_model_energy(&model, x), before - gain);
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_true(slow_is_kept(&model, p, x[p]));
        }
        solved += !patient || size < sizeof memory || before - gain == least_of_all();
    }
    print_message("optimal: %u of %d\n", solved, FEWER);
    assert_true(solved > FEWER * 9 / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(merging_takes_the_best_parts),
        cmocka_unit_test(moves_on_trees_are_exact),
        cmocka_unit_test(kicks_never_raise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
