/* Segmentation: costs and weights beside their formulas in floating point, strokes, refitting. */
#include "costs.h"

#include <math.h>
#include <stdlib.h>

#include "makers/logarithm.h"

enum { WIDTH = 11, HEIGHT = 7, PIXELS = WIDTH * HEIGHT, CLASSES = 3 };

static uint8_t photo[HEIGHT][3 * WIDTH + 4], strokes[PIXELS];

static qs_segment picture(uint64_t *state, unsigned channels)
{
    for (int i = 0; i < PIXELS; i++) {
        int x = i % WIDTH, y = i / WIDTH;
        for (unsigned c = 0; c < channels; c++) {
            photo[y][x * (int)channels + (int)c] = (uint8_t)(40 * tiny_random(state, 6));
        }
        strokes[i] = tiny_random(state, 3) == 0 ? (uint8_t)(1 + tiny_random(state, CLASSES)) : 0;
    }
    strokes[0] = 1;
    strokes[1] = 2;
    strokes[2] = 3;
    return (qs_segment){.photo = photo[0],
                        .width = WIDTH,
                        .height = HEIGHT,
                        .stride = sizeof photo[0],
                        .channels = channels,
                        .strokes = strokes,
                        .classes = CLASSES,
                        .scale = 1000,
                        .weight = 1 << 20};
}

static uint32_t bin(const qs_segment *s, int pixel)
{
    uint32_t found = 0;
    for (unsigned c = 0; c < s->channels; c++) {
        found = found * 16 + photo[pixel / WIDTH][pixel % WIDTH * (int)s->channels + (int)c] / 16;
    }
    return found;
}

/* -ln P of the colour of a pixel, where class[i] is the class of each pixel that counts, or -1. */
static double slow_cost(const qs_segment *s, const int *class, int pixel, int asked)
{
    double same = 0, all = 0, bins = s->channels == 3 ? 4096 : 16;
    for (int i = 0; i < PIXELS; i++) {
        all += class[i] == asked;
        same += class[i] == asked && bin(s, i) == bin(s, pixel);
    }
    return -log((16 * same + 1) / (16 * all + bins));
}

/* Rounding of the logarithms takes less than two units. */
static void check_costs(const qs_segment *s, const qs_problem *p, const int *class)
{
    static int64_t costs[COSTS_ROW];
    for (int y = 0; y < HEIGHT; y++) {
        costs_of_row(p, (uint32_t)y, costs);
        for (int i = 0; i < WIDTH * CLASSES; i++) {
            double cost = slow_cost(s, class, y * WIDTH + i / CLASSES, i % CLASSES) * s->scale;
            assert_true(fabs(cost - (double)costs[i]) < 2);
        }
    }
}

static double contrast(const qs_segment *s, int p, int q)
{
    double sum = 0;
    for (unsigned c = 0; c < s->channels; c++) {
        double off = photo[p / WIDTH][p % WIDTH * (int)s->channels + (int)c] -
                     photo[q / WIDTH][q % WIDTH * (int)s->channels + (int)c];
        sum += off * off;
    }
    return sum;
}

/* The table of exponentials has steps of 1 / 32: its values are right to a part in 60. */
static void check_weight(double weight, double beta, double contrast, int32_t found)
{
    double right = weight * exp(-beta * contrast);
    assert_true(fabs(right - found) <= right / 60 + 1);
}

static void check_weights(const qs_segment *s, const qs_problem *p)
{
    double sum = 0;
    int edges = 0;
    for (int i = 0; i < PIXELS; i++) {
        bool right = i % WIDTH + 1 < WIDTH, down = i + WIDTH < PIXELS;
        sum += (right ? contrast(s, i, i + 1) : 0) + (down ? contrast(s, i, i + WIDTH) : 0);
        edges += right + down;
    }
    for (int i = 0; i < PIXELS; i++) {
        if (i % WIDTH + 1 < WIDTH) {
            check_weight(s->weight, edges / (2 * sum), contrast(s, i, i + 1), p->grid.right[i]);
        }
        if (i + WIDTH < PIXELS) {
            check_weight(s->weight, edges / (2 * sum), contrast(s, i, i + WIDTH), p->grid.down[i]);
        }
    }
}

static void costs_are_those_of_the_strokes(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    for (unsigned channels = 1; channels <= 3; channels += 2) {
        qs_segment s = picture(&state, channels);
        qs_problem p;
        int class[PIXELS];
        size_t size = qs_segment_workspace(&s);
        void *memory = malloc(size);
        assert_int_equal(qs_segment_problem(&s, memory, size - 1, &p), QS_E_WORKSPACE);
        assert_int_equal(qs_segment_problem(&s, memory, size, &p), QS_OK);
        assert_int_equal(p.meaning.kind, QS_MEANS_CLASS);
        assert_int_equal(p.frame.first, 1);
        for (int i = 0; i < PIXELS; i++) {
            class[i] = strokes[i] - 1;
            for (int c = 0; c < CLASSES; c++) {
                assert_int_equal(p.allowed[i * CLASSES + c] != 0,
                                 strokes[i] == 0 || strokes[i] == c + 1);
            }
        }
        check_costs(&s, &p, class);
        check_weights(&s, &p);
        free(memory);
    }
}

static void classes_without_strokes_have_the_rest(void **unused)
{
    (void)unused;
    uint64_t state = 2;
    qs_segment s = picture(&state, 3);
    static int64_t costs[COSTS_ROW];
    int class[PIXELS];
    qs_problem p;
    size_t size = qs_segment_workspace(&s);
    void *memory = malloc(size);
    for (int i = 0; i < PIXELS; i++) {
        strokes[i] = strokes[i] == 1;
        class[i] = strokes[i] == 1 ? 0 : 1;
    }
    assert_int_equal(qs_segment_problem(&s, memory, size, &p), QS_OK);
    for (int y = 0; y < HEIGHT; y++) {
        costs_of_row(&p, (uint32_t)y, costs);
        for (int x = 0; x < WIDTH; x++) {
            double cost = slow_cost(&s, class, y * WIDTH + x, 1) * s.scale;
            assert_true(fabs(cost - (double)costs[x * CLASSES + 1]) < 2);
            assert_int_equal(costs[x * CLASSES + 1], costs[x * CLASSES + 2]);
        }
    }
    free(memory);
}

static void refitting_counts_the_labelling(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    qs_segment s = picture(&state, 3);
    uint16_t labelling[PIXELS];
    int class[PIXELS];
    qs_problem p;
    size_t size = qs_segment_workspace(&s);
    void *memory = malloc(size);
    assert_int_equal(qs_segment_problem(&s, memory, size, &p), QS_OK);
    for (int i = 0; i < PIXELS; i++) {
        labelling[i] = (uint16_t)tiny_random(&state, CLASSES);
        class[i] = labelling[i];
    }
    assert_int_equal(qs_segment_refit(memory, labelling), QS_OK);
    check_costs(&s, &p, class);
    /* No pixel has class 0 now: its histogram stays as it is. */
    for (int i = 0; i < PIXELS; i++) {
        labelling[i] = 1 + labelling[i] / 2;
    }
    static int64_t before[COSTS_ROW], after[COSTS_ROW];
    costs_of_row(&p, 0, before);
    assert_int_equal(qs_segment_refit(memory, labelling), QS_OK);
    costs_of_row(&p, 0, after);
    for (int x = 0; x < WIDTH; x++) {
        assert_int_equal(before[x * CLASSES], after[x * CLASSES]);
    }
    labelling[5] = CLASSES;
    assert_int_equal(qs_segment_refit(memory, labelling), QS_E_ARGUMENT);
    free(memory);
}

static void nonsense_is_refused(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    const qs_segment good = picture(&state, 3);
    qs_segment bad[8] = {good, good, good, good, good, good, good, good};
    size_t size = qs_segment_workspace(&good);
    void *memory = malloc(size);
    qs_problem p;
    bad[0].classes = 1;
    bad[1].classes = 256;
    bad[2].channels = 2;
    bad[3].stride = 3 * WIDTH - 1;
    bad[4].scale = 0;
    bad[5].weight = -1;
    bad[6].strokes = NULL; /* and no costs */
    bad[7] = good;
    strokes[5] = 200; /* refused before anything is written */
    for (int i = 7; i >= 0; i--) {
        assert_int_equal(qs_segment_problem(&bad[i], memory, size, &p), QS_E_ARGUMENT);
    }
    free(memory);
}

/* One less than what is refused is taken: then only memory is missing. */
static void largest_values_are_taken(void **unused)
{
    (void)unused;
    uint64_t state = 4, memory;
    qs_segment s = picture(&state, 3);
    qs_problem p;
    s.classes = QS_CLASSES_MAX;
    s.scale = 1000000;
    assert_int_equal(qs_segment_problem(&s, &memory, sizeof memory, &p), QS_E_WORKSPACE);
    s.scale++;
    assert_int_equal(qs_segment_problem(&s, &memory, sizeof memory, &p), QS_E_ARGUMENT);
}

/* A plain picture has no contrast: every edge has the weight lambda. */
static void plain_pictures_have_full_weights(void **unused)
{
    (void)unused;
    uint64_t state = 5;
    qs_segment s = picture(&state, 1);
    static const int32_t costs[PIXELS * CLASSES] = {0};
    size_t size = qs_segment_workspace(&s);
    void *memory = malloc(size);
    qs_problem p;
    for (int i = 0; i < PIXELS; i++) {
        photo[i / WIDTH][i % WIDTH] = 77;
    }
    s.costs = costs;
    assert_int_equal(qs_segment_problem(&s, memory, size, &p), QS_OK);
    assert_ptr_equal(p.costs, costs);
    for (int i = 0; i + 1 < WIDTH; i++) {
        assert_int_equal(p.grid.right[i], s.weight);
    }
    assert_int_equal(qs_segment_refit(memory, (uint16_t[PIXELS]){0}), QS_OK);
    free(memory);
}

static void logarithms_are_right(void **unused)
{
    (void)unused;
    uint32_t table[QS_EXP_STEPS];
    for (uint64_t value = 1; value < UINT64_C(1) << 62; value += 1 + value / 7) {
        double digits = log2((double)value) * 65536;
        assert_true(fabs(digits - qs_log2(value)) <= 1.001);
    }
    qs_exp_table(table);
    for (int i = 0; i < QS_EXP_STEPS; i++) {
        assert_true(fabs(exp(-i / 32.0) * 1073741824 - table[i]) <= 4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(costs_are_those_of_the_strokes),
        cmocka_unit_test(classes_without_strokes_have_the_rest),
        cmocka_unit_test(refitting_counts_the_labelling),
        cmocka_unit_test(nonsense_is_refused),
        cmocka_unit_test(largest_values_are_taken),
        cmocka_unit_test(plain_pictures_have_full_weights),
        cmocka_unit_test(logarithms_are_right),
    };
    return cmocka_run_group_tests_name("segment", tests, NULL, NULL);
}
