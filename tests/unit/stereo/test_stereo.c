/* From pictures to costs: grey, absolute differences, the window; scores. */
#include "tiny.h"

#include <string.h>

enum { WIDTH = 150, HEIGHT = 4, MOST_LABELS = 40 };

static uint8_t left[HEIGHT][WIDTH + 3], right[HEIGHT][WIDTH + 1];

static qs_stereo pair(void)
{
    uint64_t state = 1;
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            left[y][x] = (uint8_t)tiny_random(&state, 256);
            right[y][x] = (uint8_t)tiny_random(&state, 256);
        }
    }
    return (qs_stereo){.left = {left[0], WIDTH, HEIGHT, sizeof left[0]},
                       .right = {right[0], WIDTH, HEIGHT, sizeof right[0]},
                       .disparity_max = 15,
                       .scale = 1,
                       .weight = 20};
}

/* Costs of every row beside the definition, for numbers of labels and widths that do and do not
 * fill the tiles. */
static void costs_are_absolute_differences(void **unused)
{
    (void)unused;
    static uint64_t memory[1024];
    static uint32_t row[WIDTH * MOST_LABELS];
    int32_t least[WIDTH];
    uint64_t state = 2;
    int below = 0, both = 0;
    for (int round = 0; round < 200; round++) {
        qs_stereo s = pair();
        s.disparity_min = (int32_t)tiny_random(&state, 60) - 50;
        s.disparity_max = s.disparity_min + (int32_t)tiny_random(&state, MOST_LABELS);
        s.x = tiny_random(&state, 20);
        s.y = tiny_random(&state, HEIGHT);
        s.height = 1 + tiny_random(&state, HEIGHT - s.y);
        s.width = MOST_LABELS + 10 + tiny_random(&state, WIDTH - 20 - MOST_LABELS - 9);
        s.scale = round % 3 == 0 ? 1000 : 1;
        qs_problem p;
        assert_true(qs_stereo_workspace(&s) <= sizeof memory);
        assert_int_equal(qs_stereo_problem(&s, memory, sizeof memory, &p), QS_OK);
        bool kept[WIDTH] = {false}; /* columns whose matches are all inside */
        for (int32_t x = 0; x < WIDTH; x++) {
            kept[x] = (uint32_t)x >= s.x && (uint32_t)x < s.x + s.width &&
                      x - s.disparity_max >= 0 && x - s.disparity_min < WIDTH;
            assert_int_equal(kept[x],
                             (uint32_t)x >= p.frame.x && (uint32_t)x < p.frame.x + p.grid.width);
        }
        assert_int_equal(p.frame.first, s.disparity_min);
        below += s.disparity_min < 0;
        both += s.disparity_min < 0 && s.disparity_max > 0;
        assert_int_equal(p.source.bytes, s.scale == 1 ? 1 : 4);
        for (uint32_t y = 0; y < p.grid.height; y++) {
            p.source.row(p.source.context, y, row, least);
            for (uint32_t x = 0; x < p.grid.width; x++) {
                int32_t expected = INT32_MAX;
                for (uint32_t d = 0; d < p.labels; d++) {
                    size_t at = (size_t)x * p.labels + d;
                    int32_t cost =
                        (int32_t)(s.scale == 1 ? ((uint8_t *)row)[at] : row[at]) + least[x];
                    int32_t px = (int32_t)(p.frame.x + x), to = px - s.disparity_min - (int32_t)d;
                    int32_t theta = left[s.y + y][px] - right[s.y + y][to];
                    assert_int_equal(cost, (theta < 0 ? -theta : theta) * (int32_t)s.scale);
                    expected = cost < expected ? cost : expected;
                }
                assert_int_equal(least[x], expected);
            }
        }
    }
    assert_true(below > 50 && both > 20);
}

/* Mirrored pictures have the same costs with labels the other way round. */
static void mirrored_pair_has_opposite_disparities(void **unused)
{
    (void)unused;
    enum { LABELS = 6 };
    static uint64_t memory[2][512];
    static uint8_t mirrored[2][HEIGHT][WIDTH], rows[2][WIDTH * LABELS];
    int32_t least[2][WIDTH];
    qs_stereo s = pair(), m = s;
    qs_problem p[2];
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            mirrored[0][y][x] = left[y][WIDTH - 1 - x];
            mirrored[1][y][x] = right[y][WIDTH - 1 - x];
        }
    }
    s.disparity_min = -LABELS + 1;
    s.disparity_max = 0;
    m.left = (qs_image){mirrored[0][0], WIDTH, HEIGHT, WIDTH};
    m.right = (qs_image){mirrored[1][0], WIDTH, HEIGHT, WIDTH};
    m.disparity_max = LABELS - 1;
    assert_int_equal(qs_stereo_problem(&s, memory[0], sizeof memory[0], &p[0]), QS_OK);
    assert_int_equal(qs_stereo_problem(&m, memory[1], sizeof memory[1], &p[1]), QS_OK);
    uint32_t width = p[0].grid.width;
    assert_int_equal(width, WIDTH - LABELS + 1);
    assert_int_equal(p[1].grid.width, width);
    assert_int_equal(p[0].frame.x, 0);
    assert_int_equal(p[1].frame.x, LABELS - 1);
    for (uint32_t y = 0; y < HEIGHT; y++) {
        for (int i = 0; i < 2; i++) {
            p[i].source.row(p[i].source.context, y, rows[i], least[i]);
        }
        for (uint32_t x = 0; x < width; x++) {
            assert_int_equal(least[0][x], least[1][width - 1 - x]);
            for (uint32_t d = 0; d < LABELS; d++) {
                assert_int_equal(rows[0][x * LABELS + d],
                                 rows[1][(width - 1 - x) * LABELS + LABELS - 1 - d]);
            }
        }
    }
}

/* Rows made on the way and the same costs as an array give the same file, and the same energy;
 * masked, too. */
static void source_and_array_agree(void **unused)
{
    (void)unused;
    static uint64_t memory[1024], workspace[8192];
    static int32_t costs[WIDTH * HEIGHT * 16];
    static uint8_t mask[WIDTH * HEIGHT], files[2][WIDTH * HEIGHT * 40];
    static uint16_t labelling[WIDTH * HEIGHT];
    uint64_t state = 4;
    for (int round = 0; round < 8; round++) {
        qs_stereo s = pair();
        s.scale = round % 2 ? 3 : 1;
        qs_problem made, array;
        assert_int_equal(qs_stereo_problem(&s, memory, sizeof memory, &made), QS_OK);
        uint32_t cells = made.grid.width * made.grid.height, sites = 0;
        for (uint32_t c = 0; c < cells; c++) {
            mask[c] = round < 4 || tiny_random(&state, 3) > 0;
            uint32_t x = c % made.grid.width + made.frame.x, y = c / made.grid.width;
            for (uint32_t d = 0; mask[c] && d < made.labels; d++) {
                int32_t theta = left[y][x] - right[y][x - d];
                costs[sites * made.labels + d] = (theta < 0 ? -theta : theta) * (int32_t)s.scale;
            }
            labelling[sites] = (uint16_t)tiny_random(&state, made.labels);
            sites += mask[c];
        }
        made.grid.mask = mask;
        array = made;
        array.costs = costs;
        qs_buffer a = {files[0], sizeof files[0], 0}, b = {files[1], sizeof files[1], 0};
        qs_sink sink_a = qs_buffer_sink(&a), sink_b = qs_buffer_sink(&b);
        qs_encode_options options = {.penalty =
                                         round % 4 == 3 ? QS_PENALTY_PAPER : QS_PENALTY_LOCAL};
        assert_int_equal(qs_encode(&made, &options, &sink_a, workspace, sizeof workspace, NULL),
                         QS_OK);
        assert_int_equal(qs_encode(&array, &options, &sink_b, workspace, sizeof workspace, NULL),
                         QS_OK);
        assert_int_equal(a.size, b.size);
        assert_memory_equal(files[0], files[1], a.size);
        int64_t energy_a, energy_b;
        assert_int_equal(
            qs_problem_energy(&made, labelling, workspace, sizeof workspace, &energy_a), QS_OK);
        assert_int_equal(qs_problem_energy(&array, labelling, NULL, 0, &energy_b), QS_OK);
        assert_int_equal(energy_a, energy_b);
    }
}

static void windows(void **unused)
{
    (void)unused;
    static uint64_t memory[2048];
    qs_problem p;
    static const struct {
        uint32_t x, y, width, height;
        int32_t max, min;
        qs_status status;
    } cases[] = {
        {0, 0, WIDTH, HEIGHT, 15, 0, QS_OK},
        {149, 3, 1, 1, 15, 0, QS_OK},
        {150, 0, 1, 1, 15, 0, QS_E_GEOMETRY},
        {0, 4, 1, 1, 0, 0, QS_E_GEOMETRY},
        {100, 0, 51, 1, 15, 0, QS_E_GEOMETRY},
        {100, 2, 20, 3, 15, 0, QS_E_GEOMETRY},
        {0, 0, 15, 4, 15, 0, QS_E_GEOMETRY},
        {0, 0, 16, 4, 15, 0, QS_OK},
        {0, 0, 0, 0, 150, 0, QS_E_GEOMETRY},
        {0xffffffff, 0, 2, 1, 15, 0, QS_E_GEOMETRY},
        {20, 1, 5, 0, 15, 0, QS_E_GEOMETRY},
        {0, 0, 0, 0, 70000, 0, QS_E_LIMIT},
        {0, 0, 0, 0, 65535, 0, QS_E_LIMIT},
        {0, 0, 0, 0, 65534, 0, QS_E_WORKSPACE}, /* the memory of this test is too small for it */
        {0, 0, 1, 4, -1, -149, QS_OK},
        {0, 0, 0, 0, -1, -150, QS_E_GEOMETRY},
        {134, 0, 16, 4, 0, -15, QS_OK},
        {135, 0, 15, 4, 0, -15, QS_E_GEOMETRY},
        {0, 0, 0, 0, 75, -74, QS_OK},
        {0, 0, 0, 0, 75, -75, QS_E_GEOMETRY},
        {0, 0, 0, 0, 40000, -40000, QS_E_LIMIT},
        {0, 0, 0, 0, INT32_MAX, -INT32_MAX, QS_E_LIMIT},
        {0, 0, 0, 0, -INT32_MAX, -INT32_MAX, QS_E_GEOMETRY},
        {0, 0, 0, 0, INT32_MIN, INT32_MIN, QS_E_ARGUMENT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        qs_stereo s = pair();
        s.x = cases[i].x;
        s.y = cases[i].y;
        s.width = cases[i].width;
        s.height = cases[i].height;
        s.disparity_max = cases[i].max;
        s.disparity_min = cases[i].min;
        assert_int_equal(qs_stereo_problem(&s, memory, sizeof memory, &p), cases[i].status);
    }
    qs_stereo s = pair();
    s.right.height--;
    assert_int_equal(qs_stereo_problem(&s, memory, sizeof memory, &p), QS_E_GEOMETRY);
    s = pair();
    assert_int_equal(qs_stereo_problem(&s, memory, qs_stereo_workspace(&s) - 1, &p),
                     QS_E_WORKSPACE);
    s.disparity_min = 16;
    assert_int_equal(qs_stereo_problem(&s, memory, sizeof memory, &p), QS_E_ARGUMENT);
}

static void grey(void **unused)
{
    (void)unused;
    const uint8_t colour[2][9] = {{255, 0, 0, 0, 255, 0, 0, 0, 255},
                                  {1, 2, 3, 255, 255, 255, 10, 200, 30}};
    uint8_t got[4];
    assert_int_equal(qs_image_grey(colour[0], 2, 2, 9, 3, got), QS_OK);
    assert_int_equal(got[0], 76); /* 76.245 */
    assert_int_equal(got[1], 150); /* 149.685 */
    assert_int_equal(got[2], 2); /* 1.815 */
    assert_int_equal(got[3], 255);
    assert_int_equal(qs_image_grey(colour[1], 2, 1, 9, 4, got), QS_OK);
    assert_int_equal(got[1], (299 * 255 + 587 * 255 + 114 * 10 + 500) / 1000);
    assert_int_equal(qs_image_grey((const uint8_t[]){0, 0, 250}, 1, 1, 3, 3, got), QS_OK);
    assert_int_equal(got[0], 29); /* 28.5: halves go up */
    assert_int_equal(qs_image_grey(colour[0], 2, 2, 9, 1, got), QS_OK);
    assert_int_equal(got[2], 1);
    assert_int_equal(qs_image_grey(colour[0], 3, 2, 8, 3, got), QS_E_ARGUMENT);
    assert_int_equal(qs_image_grey(colour[0], 2, 2, 9, 2, got), QS_E_ARGUMENT);
}

static void scores(void **unused)
{
    (void)unused;
    /* Scale 8 against 4: errors of 0, 0.5 (not more than 0.5), 0.625, 1.0, 1.125 pixels, and two
     * without a value. */
    const int32_t map[7] = {16, 20, 21, 24, 25, QS_NO_DISPARITY, 8};
    const int32_t truth[7] = {8, 8, 8, 8, 8, 8, QS_NO_DISPARITY};
    qs_score s;
    qs_map a = {map, 7, 1, 8}, b = {truth, 7, 1, 4};
    assert_int_equal(qs_score_map(&a, &b, &s), QS_OK);
    assert_int_equal(s.pixels, 5);
    assert_int_equal(s.bad_half, 3);
    assert_int_equal(s.bad_one, 1);
    assert_int_equal(s.bad_two, 0);
    assert_int_equal(s.truths, 6);
    assert_int_equal(s.sum_high, 0);
    assert_int_equal(s.sum_low, 0 + 16 + 20 + 32 + 36);
    assert_int_equal(s.squares_high, 0);
    assert_int_equal(s.squares_low, (0 + 16 * 16 + 20 * 20 + 32 * 32 + 36 * 36));
    b.width = 6;
    assert_int_equal(qs_score_map(&a, &b, &s), QS_E_GEOMETRY);
    b = (qs_map){truth, 7, 1, 0};
    assert_int_equal(qs_score_map(&a, &b, &s), QS_E_ARGUMENT);
}

/* D1 counts what is off by more than 3 pixels and by more than a twentieth of the truth. */
static void d1(void **unused)
{
    (void)unused;
    const int32_t map[6] = {63, 64, 104, 106, 2, 3}, truth[6] = {60, 60, 100, 100, 0, 0};
    qs_score s;
    qs_map a = {map, 6, 1, 1}, b = {truth, 6, 1, 1};
    assert_int_equal(qs_score_map(&a, &b, &s), QS_OK);
    assert_int_equal(s.d1, 2);
    assert_int_equal(s.bad_two, 5);
}

/* Squares beyond 64 bits: (2^31 - 1) px at scale 65536 against -(2^31 - 1) at 65536, three times.
 */
static void large_squares(void **unused)
{
    (void)unused;
    const int32_t map[3] = {INT32_MAX, INT32_MAX, INT32_MAX},
                  truth[3] = {-INT32_MAX, -INT32_MAX, -INT32_MAX};
    qs_score s;
    qs_map a = {map, 3, 1, 65536}, b = {truth, 3, 1, 65536};
    assert_int_equal(qs_score_map(&a, &b, &s), QS_OK);
    /* 3 (2 (2^31 - 1) 2^16)^2 = 3 (2^96 - 2^66 + 2^34) */
    assert_int_equal(s.squares_high, 3 * ((1ull << 32) - 4));
    assert_int_equal(s.squares_low, 3 * (1ull << 34));
}

static void held_disparities(void **unused)
{
    (void)unused;
    assert_int_equal(qs_disparity_hold(0, 8), 1);
    assert_int_equal(qs_disparity_hold(15, 8), 120);
    assert_int_equal(qs_disparity_hold(65534, 256), 65534 * 256);
    assert_int_equal(qs_disparity_read(0, 8), QS_NO_DISPARITY);
    assert_int_equal(qs_disparity_read(1, 8), 0);
    assert_int_equal(qs_disparity_read(1, 1), 1);
    assert_int_equal(qs_disparity_read(120, 8), 120);
}

static void texts(void **unused)
{
    (void)unused;
    for (int status = QS_OK; status <= QS_E_INFEASIBLE; status++) {
        assert_non_null(qs_status_text((qs_status)status));
        assert_string_not_equal(qs_status_text((qs_status)status), "unknown status");
    }
    assert_string_equal(qs_status_text((qs_status)13), "unknown status");
    assert_string_equal(qs_status_text((qs_status)-1), "unknown status");
}

/* The ABI: these values never change. */
static void status_values(void **unused)
{
    (void)unused;
    const qs_status order[] = {QS_OK,          QS_E_ARGUMENT, QS_E_WORKSPACE,   QS_E_LIMIT,
                               QS_E_OVERFLOW,  QS_E_FORMAT,   QS_E_UNSUPPORTED, QS_E_CORRUPT,
                               QS_E_TRUNCATED, QS_E_IO,       QS_E_GEOMETRY,    QS_E_ENCODING,
                               QS_E_INFEASIBLE};
    for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
        assert_int_equal(order[i], i);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(costs_are_absolute_differences),
        cmocka_unit_test(mirrored_pair_has_opposite_disparities),
        cmocka_unit_test(source_and_array_agree),
        cmocka_unit_test(windows),
        cmocka_unit_test(grey),
        cmocka_unit_test(scores),
        cmocka_unit_test(d1),
        cmocka_unit_test(large_squares),
        cmocka_unit_test(held_disparities),
        cmocka_unit_test(texts),
        cmocka_unit_test(status_values),
    };
    return cmocka_run_group_tests_name("stereo", tests, NULL, NULL);
}
