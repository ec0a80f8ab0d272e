/* Flow and registration: costs, table and field beside their definitions. */
#include "costs.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 13, HEIGHT = 11 };

static uint8_t first[HEIGHT][WIDTH + 1], second[HEIGHT][WIDTH + 3];

static qs_displace pictures(uint64_t *state)
{
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            first[y][x] = (uint8_t)tiny_random(state, 256);
            second[y][x] = (uint8_t)tiny_random(state, 256);
        }
    }
    return (qs_displace){.first = {first[0], WIDTH, HEIGHT, sizeof first[0]},
                         .second = {second[0], WIDTH, HEIGHT, sizeof second[0]},
                         .step = 1 + tiny_random(state, 6),
                         .window = 1 + 2 * tiny_random(state, 4),
                         .radius_x = tiny_random(state, 8),
                         .radius_y = tiny_random(state, 5),
                         .unit = 1 + tiny_random(state, 4),
                         .scale = 1 + tiny_random(state, 3),
                         .weight = (int32_t)tiny_random(state, 50),
                         .truncation = tiny_random(state, 6)};
}

static int clamp(int value, int count)
{
    return value < 0 ? 0 : value >= count ? count - 1 : value;
}

/* The second picture at a place in parts of a pixel, times unit^2. */
static int sample(int x, int y, int unit)
{
    int left = x / unit - (x % unit < 0), top = y / unit - (y % unit < 0);
    int u = x - left * unit, v = y - top * unit, sum = 0;
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 2; i++) {
            sum += second[clamp(top + k, HEIGHT)][clamp(left + i, WIDTH)] * (i ? u : unit - u) *
                   (k ? v : unit - v);
        }
    }
    return sum;
}

static int64_t slow_cost(const qs_displace *d, int x, int y, int dx, int dy)
{
    int half = (int)d->window / 2, unit = (int)d->unit;
    int64_t sum = 0;
    for (int j = -half; j <= half; j++) {
        for (int i = -half; i <= half; i++) {
            int here = first[clamp(y + j, HEIGHT)][clamp(x + i, WIDTH)] * unit * unit;
            sum += abs(here - sample((x + i) * unit + dx, (y + j) * unit + dy, unit));
        }
    }
    return sum * d->scale;
}

static void check_costs(const qs_displace *d, const qs_problem *p)
{
    static int64_t costs[COSTS_ROW];
    for (uint32_t y = 0; y < p->grid.height; y++) {
        costs_of_row(p, y, costs);
        for (uint32_t i = 0; i < p->grid.width * p->labels; i++) {
            uint32_t x = i / p->labels, label = i % p->labels;
            int dx = p->meaning.x + (int)(label % p->meaning.columns),
                dy = p->meaning.y + (int)(label / p->meaning.columns);
            assert_int_equal(costs[i],
                             slow_cost(d, (int)(x * d->step), (int)(y * d->step), dx, dy));
        }
    }
}

static void check_table(const qs_displace *d, const qs_problem *p)
{
    int columns = (int)p->meaning.columns;
    for (int a = 0; a < (int)p->labels; a++) {
        for (int b = 0; b < (int)p->labels; b++) {
            int v = abs(a % columns - b % columns) + abs(a / columns - b / columns);
            v = d->truncation > 0 && v > (int)d->truncation ? (int)d->truncation : v;
            assert_int_equal(qs_pairwise_cost(p, (uint32_t)a, (uint32_t)b), v);
        }
    }
    /* A pixel of difference costs lambda grey levels. */
    assert_int_equal((int64_t)p->weight * d->unit * d->scale, (int64_t)d->weight * p->scale);
}

static void costs_are_mean_differences(void **unused)
{
    (void)unused;
    uint64_t state = 1;
    for (int round = 0; round < 40; round++) {
        qs_displace d = pictures(&state);
        qs_problem p;
        size_t size = qs_displace_workspace(&d);
        void *memory = malloc(size);
        assert_int_equal(qs_displace_problem(&d, memory, size - 1, &p), QS_E_WORKSPACE);
        assert_int_equal(qs_displace_problem(&d, memory, size, &p), QS_OK);
        assert_int_equal(p.scale, d.window * d.window * d.unit * d.unit * d.scale);
        assert_int_equal(p.labels, (2 * d.radius_x + 1) * (2 * d.radius_y + 1));
        /* The last site is the first one that is not before the last pixel. */
        assert_true((p.grid.width - 1) * d.step >= WIDTH - 1 &&
                    (p.grid.width - 1) * d.step < WIDTH - 1 + d.step);
        check_costs(&d, &p);
        check_table(&d, &p);
        free(memory);
    }
}

/* The field has the labels' displacements at the sites, and is a plane between the sites of a
 * plane. */
static void field_is_bilinear(void **unused)
{
    (void)unused;
    static int32_t field[HEIGHT * WIDTH * 2];
    uint16_t labelling[16];
    const qs_meaning meaning = {QS_MEANS_DISPLACEMENT, 4, 30, 2, -9, -7};
    for (int i = 0; i < 16; i++) {
        labelling[i] = (uint16_t)((i / 4 * 3 + 2) * 30 + i % 4 * 5); /* dx rises by 5, dy by 3 */
    }
    assert_int_equal(qs_displace_field(&meaning, 4, 4, labelling, WIDTH, HEIGHT, field), QS_OK);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            assert_int_equal(field[2 * (y * WIDTH + x)], 16 * -9 + 4 * 5 * x);
            assert_int_equal(field[2 * (y * WIDTH + x) + 1], 16 * (-7 + 2) + 4 * 3 * y);
        }
    }
    qs_meaning other = meaning;
    other.kind = QS_MEANS_GREY;
    assert_int_equal(qs_displace_field(&other, 4, 4, labelling, WIDTH, HEIGHT, field),
                     QS_E_ARGUMENT);
    assert_int_equal(qs_displace_field(&meaning, 4, 3, labelling, WIDTH, HEIGHT, field),
                     QS_E_ARGUMENT);
    other = meaning;
    other.step = 60000;
    assert_int_equal(qs_displace_field(&other, 2, 2, labelling, WIDTH, HEIGHT, field),
                     QS_E_OVERFLOW);
}

static void nonsense_is_refused(void **unused)
{
    (void)unused;
    static uint64_t memory[1 << 16];
    uint64_t state = 2;
    const qs_displace good = pictures(&state);
    const struct {
        size_t offset;
        uint32_t value;
        qs_status status;
    } cases[] = {
        {offsetof(qs_displace, step), 0, QS_E_ARGUMENT},
        {offsetof(qs_displace, window), 4, QS_E_ARGUMENT},
        {offsetof(qs_displace, window), 257, QS_E_ARGUMENT},
        {offsetof(qs_displace, unit), 0, QS_E_ARGUMENT},
        {offsetof(qs_displace, unit), 17, QS_E_ARGUMENT},
        {offsetof(qs_displace, scale), 0, QS_E_ARGUMENT},
        {offsetof(qs_displace, scale), 1u << 30, QS_E_OVERFLOW},
        {offsetof(qs_displace, weight), UINT32_MAX, QS_E_ARGUMENT},
        {offsetof(qs_displace, radius_x), 65536, QS_E_LIMIT},
    };
    qs_problem p;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        qs_displace bad = good;
        memcpy((char *)&bad + cases[i].offset, &cases[i].value, sizeof cases[i].value);
        assert_int_equal(qs_displace_problem(&bad, memory, sizeof memory, &p), cases[i].status);
    }
    qs_displace bad = good;
    bad.second.height--;
    assert_int_equal(qs_displace_problem(&bad, memory, sizeof memory, &p), QS_E_GEOMETRY);
}

/* The largest value of each field is taken: then only room for labels or memory is missing. A
 * little more is refused. */
static void largest_values_are_taken(void **unused)
{
    (void)unused;
    uint64_t state = 2, memory;
    const struct {
        size_t offset;
        uint32_t most;
    } cases[] = {
        {offsetof(qs_displace, step), 65535},     {offsetof(qs_displace, window), 255},
        {offsetof(qs_displace, unit), 16},        {offsetof(qs_displace, radius_x), 65536},
        {offsetof(qs_displace, radius_y), 65536},
    };
    qs_problem p;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (uint32_t more = 0; more <= 2; more += 2) { /* a window is odd */
            qs_displace d = pictures(&state);
            d.window = d.unit = d.scale = 1;
            uint32_t value = cases[i].most + more;
            memcpy((char *)&d + cases[i].offset, &value, sizeof value);
            qs_status status = qs_displace_problem(&d, &memory, sizeof memory, &p);
            assert_true(more ? status == QS_E_ARGUMENT
                             : status == QS_E_LIMIT || status == QS_E_WORKSPACE);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(costs_are_mean_differences),
        cmocka_unit_test(field_is_bilinear),
        cmocka_unit_test(nonsense_is_refused),
        cmocka_unit_test(largest_values_are_taken),
    };
    return cmocka_run_group_tests_name("displace", tests, NULL, NULL);
}
