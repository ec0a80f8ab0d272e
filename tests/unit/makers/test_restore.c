/* Restoration: costs beside their definition, holes, and what is refused. */
#include "costs.h"

#include <stdlib.h>

enum { WIDTH = 9, HEIGHT = 5 };

static uint8_t noisy[HEIGHT][WIDTH + 2], hole[HEIGHT * WIDTH];

static qs_restore picture(uint64_t *state)
{
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            noisy[y][x] = (uint8_t)tiny_random(state, 256);
            hole[y * WIDTH + x] = tiny_random(state, 3) == 0 ? 255 : 0;
        }
    }
    return (qs_restore){.noisy = {noisy[0], WIDTH, HEIGHT, sizeof noisy[0]},
                        .hole = hole,
                        .cost = (qs_restore_cost)tiny_random(state, 2),
                        .step = 1 + tiny_random(state, 255),
                        .scale = 1 + tiny_random(state, 1000),
                        .weight = 5,
                        .pairwise = {QS_TRUNCATED_QUADRATIC, 7, NULL}};
}

static void costs_are_distances_of_greys(void **unused)
{
    (void)unused;
    static int64_t costs[COSTS_ROW];
    uint64_t state = 1;
    void *memory = malloc(qs_restore_workspace());
    for (int round = 0; round < 40; round++) {
        qs_restore r = picture(&state);
        qs_problem p;
        r.hole = round % 4 == 0 ? NULL : hole;
        assert_int_equal(qs_restore_problem(&r, memory, qs_restore_workspace(), &p), QS_OK);
        assert_int_equal(p.labels, 255 / r.step + 1);
        assert_int_equal(p.weight, 5);
        assert_int_equal(p.pairwise.truncation, 7);
        assert_int_equal(p.meaning.kind, QS_MEANS_GREY);
        assert_int_equal(p.meaning.step, r.step);
        for (uint32_t y = 0; y < HEIGHT; y++) {
            costs_of_row(&p, y, costs);
            for (uint32_t i = 0; i < WIDTH * p.labels; i++) {
                int64_t x = i / p.labels, off = noisy[y][x] - (int64_t)(i % p.labels * r.step);
                int64_t cost = r.cost == QS_RESTORE_SQUARED ? off * off : llabs(off);
                bool free_of_cost = r.hole && hole[y * WIDTH + (uint32_t)x] != 0;
                assert_int_equal(costs[i], free_of_cost ? 0 : cost * r.scale);
            }
        }
    }
    free(memory);
}

static void nonsense_is_refused(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    size_t size = qs_restore_workspace();
    void *memory = malloc(size);
    const qs_restore good = picture(&state);
    qs_restore bad[6] = {good, good, good, good, good, good};
    qs_problem p;
    bad[0].step = 0;
    bad[1].step = 256;
    bad[2].scale = 0;
    bad[3].scale = 1 << 20;
    bad[4].weight = -1;
    bad[5].noisy.stride = WIDTH - 1;
    for (int i = 0; i < 6; i++) {
        assert_int_equal(qs_restore_problem(&bad[i], memory, size, &p), QS_E_ARGUMENT);
    }
    assert_int_equal(qs_restore_problem(&good, memory, size - 1, &p), QS_E_WORKSPACE);
    assert_int_equal(qs_restore_problem(&good, memory, size, &p), QS_OK);
    free(memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(costs_are_distances_of_greys),
        cmocka_unit_test(nonsense_is_refused),
    };
    return cmocka_run_group_tests_name("restore", tests, NULL, NULL);
}
