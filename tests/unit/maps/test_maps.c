/* What is done with maps after the labels, beside the definitions. */
#include "modelled.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 9, HEIGHT = 5, CELLS = WIDTH * HEIGHT };

#define NONE QS_NO_DISPARITY

static void random_map(uint64_t *state, int32_t map[CELLS], uint32_t holes)
{
    for (int i = 0; i < CELLS; i++) {
        bool none = tiny_random(state, 10) < holes;
        map[i] = none ? NONE : (int32_t)tiny_random(state, 12) - 3;
    }
}

/* The match of column x is x - value / unit, rounded; halves go to the right. */
static void consistency(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    for (int round = 0; round < 200; round++) {
        int32_t left[CELLS], right[CELLS], checked[CELLS];
        uint32_t unit = 1u << tiny_random(&state, 5), tolerance = tiny_random(&state, 4);
        random_map(&state, left, 2);
        random_map(&state, right, 2);
        memcpy(checked, left, sizeof left);
        assert_int_equal(qs_map_check(checked, right, WIDTH, HEIGHT, unit, tolerance), QS_OK);
        for (int i = 0; i < CELLS; i++) {
            int32_t expected = NONE;
            for (int x = 0; x < WIDTH && left[i] != NONE; x++) {
                /* how far column x is to the right of the match, in halves of parts */
                int off = 2 * (x - i % WIDTH) * (int)unit + 2 * left[i];
                int32_t other = right[i - i % WIDTH + x];
                bool agrees = other != NONE && abs(other - left[i]) <= (int)tolerance;
                if (off > -(int)unit && off <= (int)unit && agrees) {
                    expected = left[i];
                }
            }
            assert_int_equal(checked[i], expected);
        }
    }
}

static void filling(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    for (int round = 0; round < 200; round++) {
        int32_t map[CELLS], filled[CELLS];
        random_map(&state, map, tiny_random(&state, 11));
        memcpy(filled, map, sizeof map);
        assert_int_equal(qs_map_fill(filled, WIDTH, HEIGHT), QS_OK);
        for (int i = 0; i < CELLS; i++) {
            int32_t before = NONE, after = NONE;
            for (int x = 0; x < i % WIDTH; x++) {
                int32_t value = map[i - i % WIDTH + x];
                before = value != NONE ? value : before;
            }
            for (int x = WIDTH - 1; x > i % WIDTH; x--) {
                int32_t value = map[i - i % WIDTH + x];
                after = value != NONE ? value : after;
            }
            int32_t expected = map[i] != NONE                                        ? map[i]
                               : before == NONE || (after != NONE && after < before) ? after
                                                                                     : before;
            assert_int_equal(filled[i], expected);
        }
    }
}

/* The lower median has less than half of the values below it, and at least half at or below. */
static void median(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    for (int round = 0; round < 200; round++) {
        int32_t map[CELLS], out[CELLS];
        random_map(&state, map, tiny_random(&state, 6));
        assert_int_equal(qs_map_median(map, WIDTH, HEIGHT, out), QS_OK);
        for (int i = 0; i < CELLS; i++) {
            int count = 0, below = 0, upto = 0;
            for (int j = 0; j < CELLS; j++) {
                bool near = abs(j % WIDTH - i % WIDTH) <= 1 && abs(j / WIDTH - i / WIDTH) <= 1;
                count += near && map[j] != NONE;
                below += near && map[j] != NONE && map[j] < out[i];
                upto += near && map[j] != NONE && map[j] <= out[i];
            }
            assert_int_equal(out[i] == NONE, map[i] == NONE);
            if (map[i] != NONE) {
                assert_true(2 * below < count && 2 * upto >= count);
            }
        }
    }
}

/* Rounded up: less than one above the sum over the count, and not below it. */
static void mean(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    for (int round = 0; round < 200; round++) {
        uint16_t map[CELLS], out[CELLS];
        int width = 1 + round % WIDTH, height = 1 + round / WIDTH % HEIGHT, cells = width * height;
        for (int i = 0; i < cells; i++) {
            bool none = tiny_random(&state, 4) == 0;
            map[i] = (uint16_t)(none ? 0 : UINT16_MAX - tiny_random(&state, round % 2 ? 9 : 65535));
        }
        assert_int_equal(qs_map_mean(map, (size_t)width, (size_t)height, out), QS_OK);
        for (int i = 0; i < cells; i++) {
            int64_t count = 0, sum = 0;
            for (int j = 0; j < cells; j++) {
                bool near = abs(j % width - i % width) <= 1 && abs(j / width - i / width) <= 1;
                count += near;
                sum += near ? map[j] : 0;
            }
            assert_true(map[i] == 0 ? out[i] == 0
                                    : count * out[i] >= sum && count * (out[i] - 1) < sum);
        }
    }
}

/* A parabola whose least is at a known place is found there. */
static void refinement(void **unused)
{
    (void)unused;
    enum { LABELS = 7 };
    for (int unit = 1; unit <= 16; unit *= 2) {
        int parts = 16 / unit;
        for (int place = -parts / 2 + 1; place < parts / 2; place++) {
            for (int label = 0; label < LABELS; label++) {
                int32_t costs[LABELS], weight = 0, value;
                uint16_t found = (uint16_t)label;
                for (int d = 0; d < LABELS; d++) {
                    int off = (d - label) * parts - place;
                    costs[d] = 3 * off * off;
                }
                const qs_model one = {.sites = 1,
                                      .labels = LABELS,
                                      .unary = costs,
                                      .width = 1,
                                      .height = 1,
                                      .right = &weight,
                                      .down = &weight};
                qs_labels labels = {.sites = 1,
                                    .labels = LABELS,
                                    .width = 1,
                                    .height = 1,
                                    .frame = {1, 1, 0, 0, 30}};
                labels.meaning.unit = unit > 1 ? (uint32_t)unit : 0;
                assert_int_equal(qs_map_refine(&one, &labels, &found, &value), QS_OK);
                bool inner = label > 0 && label < LABELS - 1;
                assert_int_equal(value, (30 + label) * parts + (inner ? place : 0));
            }
        }
    }
}

/* Costs beside a label that is not the cheapest, or no cheaper than others, do not move it. */
static void refinement_stays(void **unused)
{
    (void)unused;
    int32_t costs[3] = {4, 5, 9}, weight = 0, value;
    uint16_t label = 1;
    const qs_model one = {.sites = 1,
                          .labels = 3,
                          .unary = costs,
                          .width = 1,
                          .height = 1,
                          .right = &weight,
                          .down = &weight};
    qs_labels labels = {.sites = 1, .labels = 3, .width = 1, .height = 1, .frame = {1, 1, 0, 0, 0}};
    assert_int_equal(qs_map_refine(&one, &labels, &label, &value), QS_OK);
    assert_int_equal(value, 16);
    costs[0] = costs[2] = 5;
    assert_int_equal(qs_map_refine(&one, &labels, &label, &value), QS_OK);
    assert_int_equal(value, 16);
    costs[0] = 7, costs[2] = 5; /* as cheap as the one behind: half way */
    assert_int_equal(qs_map_refine(&one, &labels, &label, &value), QS_OK);
    assert_int_equal(value, 24);
    labels.meaning.unit = 3;
    assert_int_equal(qs_map_refine(&one, &labels, &label, &value), QS_E_ARGUMENT);
    labels.meaning = (qs_meaning){.kind = QS_MEANS_CLASS};
    assert_int_equal(qs_map_refine(&one, &labels, &label, &value), QS_E_ARGUMENT);
}

/* The least energy of a row or a column alone with one label given: every labelling of it is
 * tried. */
static int64_t least_of_chain(uint32_t cell, bool down, uint32_t label)
{
    uint32_t stride = down ? model.width : 1, count = down ? model.height : model.width;
    uint32_t first = down ? cell % model.width : cell - cell % model.width, states = 1;
    int64_t least = INT64_MAX;
    for (uint32_t i = 0; i < count; i++) {
        states *= model.labels;
    }
    for (uint32_t state = 0; state < states; state++) {
        uint32_t rest = state, before = 0, at = 0;
        int64_t energy = 0;
        for (uint32_t i = 0; i < count; i++, rest /= model.labels) {
            uint32_t p = first + i * stride, own = rest % model.labels;
            energy += model.unary[p * model.labels + own];
            if (i > 0) {
                uint32_t from = p - stride;
                energy += (down ? model.down : model.right)[from] *
                          qs_model_edge_pairwise(&model, 2 * from + down, before, own);
            }
            at = p == cell ? own : at;
            before = own;
        }
        least = at == label && energy < least ? energy : least;
    }
    return least;
}

static uint32_t margin_of(const uint16_t *labelling, uint32_t cell, uint32_t apart)
{
    int64_t margin = UINT32_MAX;
    for (int down = 0; down < 2; down++) {
        int64_t own = least_of_chain(cell, down, labelling[cell]), other = INT64_MAX;
        for (uint32_t d = 0; d < model.labels; d++) {
            uint32_t off = d > labelling[cell] ? d - labelling[cell] : labelling[cell] - d;
            int64_t cost = off > apart ? least_of_chain(cell, down, d) : INT64_MAX;
            other = cost < other ? cost : other;
        }
        int64_t here = other == INT64_MAX ? UINT32_MAX : other > own ? other - own : 0;
        margin = here < margin ? here : margin;
    }
    return (uint32_t)margin;
}

static void margins(void **unused)
{
    (void)unused;
    static uint64_t memory[4096];
    uint64_t state = 5;
    int tried = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[TINY_SITES];
        uint32_t found[TINY_SITES], apart = tiny_random(&state, 3);
        make_model(&state, false, QS_ONE_HOT);
        if (model.width == 0 || model.mask) {
            continue;
        }
        for (uint32_t p = 0; p < model.sites; p++) {
            labelling[p] = (uint16_t)tiny_random(&state, model.labels);
        }
        size_t size = qs_margins_workspace(&model);
        assert_true(size <= sizeof memory);
        assert_int_equal(qs_margins(&model, labelling, apart, memory, size, found), QS_OK);
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_int_equal(found[p], margin_of(labelling, p, apart));
        }
        tried++;
    }
    assert_true(tried > ROUNDS / 10);
}

static void refusals(void **unused)
{
    (void)unused;
    int32_t map[CELLS] = {0}, other[CELLS];
    assert_int_equal(qs_map_check(NULL, map, WIDTH, HEIGHT, 1, 1), QS_E_ARGUMENT);
    assert_int_equal(qs_map_check(map, NULL, WIDTH, HEIGHT, 1, 1), QS_E_ARGUMENT);
    assert_int_equal(qs_map_check(map, other, WIDTH, HEIGHT, 0, 1), QS_E_ARGUMENT);
    assert_int_equal(qs_map_check(map, other, WIDTH, HEIGHT, 65537, 1), QS_E_ARGUMENT);
    assert_int_equal(qs_map_check(map, map, WIDTH, HEIGHT, 65536, 1), QS_OK);
    assert_int_equal(qs_map_fill(NULL, WIDTH, HEIGHT), QS_E_ARGUMENT);
    assert_int_equal(qs_map_median(map, WIDTH, HEIGHT, map), QS_E_ARGUMENT);
    assert_int_equal(qs_map_median(map, WIDTH, HEIGHT, NULL), QS_E_ARGUMENT);
    assert_int_equal(qs_map_refine(NULL, NULL, NULL, map), QS_E_ARGUMENT);
    uint16_t greys[CELLS] = {0}, means[CELLS];
    assert_int_equal(qs_map_mean(NULL, WIDTH, HEIGHT, means), QS_E_ARGUMENT);
    assert_int_equal(qs_map_mean(greys, WIDTH, HEIGHT, NULL), QS_E_ARGUMENT);
    assert_int_equal(qs_map_mean(greys, WIDTH, HEIGHT, greys), QS_E_ARGUMENT);
    int32_t costs[2] = {0, 1}, weight = 0;
    uint64_t memory[64];
    uint16_t label = 2;
    uint32_t margin = 7;
    qs_model one = {.sites = 1,
                    .labels = 2,
                    .unary = costs,
                    .width = 1,
                    .height = 1,
                    .right = &weight,
                    .down = &weight};
    size_t size = qs_margins_workspace(&one);
    assert_true(size <= sizeof memory);
    assert_int_equal(qs_margins(&one, &label, 0, memory, size, &margin), QS_E_ARGUMENT);
    label = 0;
    assert_int_equal(qs_margins(&one, &label, 0, memory, size - 1, &margin), QS_E_WORKSPACE);
    one.width = 0;
    assert_int_equal(qs_margins(&one, &label, 0, memory, size, &margin), QS_E_GEOMETRY);
    assert_int_equal(margin, 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(consistency), cmocka_unit_test(filling),
        cmocka_unit_test(median),      cmocka_unit_test(mean),
        cmocka_unit_test(refinement),  cmocka_unit_test(refinement_stays),
        cmocka_unit_test(margins),     cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("maps", tests, NULL, NULL);
}
