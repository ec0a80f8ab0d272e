/* Overlapping boxes: costs and edges beside their formulas in floating point. */
#include "tiny.h"

#include <math.h>
#include <stdlib.h>

enum { BOXES = 60 };

static qs_box boxes[BOXES];

static void make_boxes(uint64_t *state)
{
    for (int i = 0; i < BOXES; i++) {
        boxes[i] = (qs_box){tiny_random(state, 2),
                            (int32_t)tiny_random(state, 40) - 20,
                            (int32_t)tiny_random(state, 40) - 20,
                            1 + (int32_t)tiny_random(state, 30),
                            1 + (int32_t)tiny_random(state, 30),
                            (int32_t)tiny_random(state, 400) - 100};
    }
}

/* Counts cells: the slow way to an area. */
static double iou(const qs_box *a, const qs_box *b)
{
    int both = 0, any = 0;
    for (int y = -20; y < 60; y++) {
        for (int x = -20; x < 60; x++) {
            bool in_a = x >= a->x && x < a->x + a->width && y >= a->y && y < a->y + a->height;
            bool in_b = x >= b->x && x < b->x + b->width && y >= b->y && y < b->y + b->height;
            both += in_a && in_b;
            any += in_a || in_b;
        }
    }
    return a->picture == b->picture ? (double)both / any : 0;
}

static void problem_is_the_formula(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    for (int round = 0; round < 5; round++) {
        qs_problem p;
        size_t at = 0, size;
        make_boxes(&state);
        size = qs_overlap_workspace(boxes, BOXES);
        void *memory = malloc(size);
        assert_int_equal(qs_overlap_problem(boxes, BOXES, memory, size - 1, &p), QS_E_WORKSPACE);
        assert_int_equal(qs_overlap_problem(boxes, BOXES, memory, size, &p), QS_OK);
        assert_int_equal(p.sites, BOXES);
        assert_int_equal(p.scale, 100);
        assert_int_equal(p.meaning.kind, QS_MEANS_KEEP);
        for (uint32_t a = 0; a < 2; a++) {
            for (uint32_t b = 0; b < 2; b++) {
                assert_int_equal(qs_pairwise_cost(&p, a, b), a == 1 && b == 1);
            }
        }
        for (uint32_t i = 0; i < BOXES; i++) {
            assert_int_equal(p.costs[2 * i], 0);
            assert_int_equal(p.costs[2 * i + 1], -boxes[i].score);
            for (uint32_t j = i + 1; j < BOXES; j++) {
                double overlap = iou(&boxes[i], &boxes[j]);
                if (overlap > 0.1 + 1e-9) {
                    assert_int_equal(p.edges[at].first, i);
                    assert_int_equal(p.edges[at].second, j);
                    assert_int_equal(p.edges[at++].weight, floor(400 * overlap + 0.5 + 1e-9));
                }
            }
        }
        assert_int_equal(p.edge_count, at);
        assert_true(at > 100);
        free(memory);
    }
}

/* The largest boxes that are allowed do not overflow: whole and half overlap. */
static void large_boxes(void **unused)
{
    (void)unused;
    const int32_t most = 1 << 26;
    const qs_box large[3] = {{1, -most, most, most, most, 1 << 30},
                             {1, -most, most, most, most, -(1 << 30)},
                             {1, -most, most, most / 2, most, 0}};
    static uint64_t memory[64];
    qs_problem p;
    assert_int_equal(qs_overlap_problem(large, 3, memory, sizeof memory, &p), QS_OK);
    assert_int_equal(p.edge_count, 3);
    assert_int_equal(p.edges[0].weight, 400);
    assert_int_equal(p.edges[1].weight, 200);
    assert_int_equal(p.edges[2].weight, 200);
}

static void nonsense_is_refused(void **unused)
{
    (void)unused;
    static uint64_t memory[4096];
    const int32_t most = 1 << 26;
    const qs_box bad[] = {{1, most + 1, 0, 1, 1, 0},
                          {1, 0, -most - 1, 1, 1, 0},
                          {1, 0, 0, 0, 1, 0},
                          {1, 0, 0, 1, most + 1, 0},
                          {1, 0, 0, 1, 1, (1 << 30) + 1}};
    qs_problem p;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(qs_overlap_problem(&bad[i], 1, memory, sizeof memory, &p), QS_E_ARGUMENT);
        assert_int_equal(qs_overlap_workspace(&bad[i], 1), SIZE_MAX);
    }
    /* The areas of both together are beyond an int64_t. */
    const qs_box huge = {1, 0, 0, INT32_MAX, INT32_MAX, 0}, two[] = {huge, huge};
    assert_int_equal(qs_overlap_workspace(two, 2), SIZE_MAX);
    assert_int_equal(qs_overlap_problem(boxes, 0, memory, sizeof memory, &p), QS_E_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(problem_is_the_formula),
        cmocka_unit_test(large_boxes),
        cmocka_unit_test(nonsense_is_refused),
    };
    return cmocka_run_group_tests_name("overlap", tests, NULL, NULL);
}
