/* Costs, labels and weights of matching beside their definitions, pixel by pixel. */
#include "tiny.h"

#include <string.h>

enum { WIDTH = 150, HEIGHT = 9, MOST_LABELS = 40, MEMORY = 1 << 16 };

static uint8_t left[HEIGHT][WIDTH + 3], right[HEIGHT][WIDTH + 1];
static uint64_t memory[MEMORY];
static uint32_t row[WIDTH * MOST_LABELS];

/* A pair, the right picture like the left one in places, so that small costs are tried too. */
static void draw(uint64_t *state)
{
    uint32_t range = tiny_random(state, 2) == 0 ? 256 : 8;
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            left[y][x] = (uint8_t)(tiny_random(state, range) * (range == 8 ? 36 : 1));
            right[y][x] = (uint8_t)(tiny_random(state, range) * (range == 8 ? 36 : 1));
        }
    }
}

static qs_matching pair(void)
{
    return (qs_matching){
        .left = {left[0], WIDTH, HEIGHT, sizeof left[0]},
        .right = {right[0], WIDTH, HEIGHT, sizeof right[0]},
        .terms = {{.cost = QS_MATCH_AD, .weight = 1}},
        .term_count = 1,
        .parts = 1,
        .disparity_max = 15,
        .scale = 1,
        .weight = 20,
    };
}

static int clamp(int value, int most)
{
    return value < 0 ? 0 : value > most ? most : value;
}

/* The sample of a picture at half column `at` of row y; the nearest one outside. */
static int sample(const qs_image *image, int at, int y)
{
    int odd = at & 1, x = clamp((at + odd) / 2, WIDTH - 1);
    const uint8_t *pixels = image->pixels + (size_t)clamp(y, HEIGHT - 1) * image->stride;
    return odd ? (pixels[x > 0 ? x - 1 : 0] + pixels[x] + 1) / 2 : pixels[x];
}

/* A picture that begins with half a pixel has its samples at odd half columns. */
static int neighbour(const qs_image *image, int at, int dx, int y)
{
    int odd = at & 1, x = clamp((at + odd) / 2 + dx, WIDTH - 1);
    return sample(image, 2 * x - odd, y);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static int outside(const qs_image *of, int of_at, const qs_image *other, int at, int y)
{
    int own = 2 * neighbour(of, of_at, 0, y), middle = neighbour(other, at, 0, y);
    int a = middle + neighbour(other, at, -1, y), b = middle + neighbour(other, at, 1, y);
    int low = smaller(2 * middle, smaller(a, b)), high = larger(2 * middle, larger(a, b));
    return larger(0, larger(own - high, low - own));
}

static int census(const qs_matching *m, const qs_match_term *term, int l, int r, int y)
{
    int off = 0, across = (int)term->width / 2, down = (int)term->height / 2;
    for (int dy = -down; dy <= down; dy++) {
        for (int dx = -across; dx <= across; dx++) {
            bool a = neighbour(&m->left, l, dx, y + dy) < neighbour(&m->left, l, 0, y);
            bool b = neighbour(&m->right, r, dx, y + dy) < neighbour(&m->right, r, 0, y);
            off += a != b;
        }
    }
    return off;
}

/* theta of a pixel, with a disparity in parts. */
static int theta(const qs_matching *m, int x, int y, int disparity)
{
    int l = 2 * x, r = 2 * x - disparity * 2 / (int)m->parts, sum = 0;
    if (r < 0 || r > 2 * (WIDTH - 1)) {
        return (int)(m->terms[0].weight * m->terms[0].truncation);
    }
    for (unsigned i = 0; i < m->term_count; i++) {
        const qs_match_term *term = &m->terms[i];
        int apart = sample(&m->left, l, y) - sample(&m->right, r, y), cost = 0;
        switch (term->cost) {
        case QS_MATCH_AD: cost = apart < 0 ? -apart : apart; break;
        case QS_MATCH_SD: cost = apart * apart; break;
        case QS_MATCH_BT:
            cost = smaller(outside(&m->left, l, &m->right, r, y),
                           outside(&m->right, r, &m->left, l, y));
            break;
        case QS_MATCH_CENSUS: cost = census(m, term, l, r, y); break;
        }
        cost = term->truncation > 0 ? smaller(cost, (int)term->truncation) : cost;
        sum += (int)term->weight * cost;
    }
    return sum;
}

static qs_match_term random_term(uint64_t *state)
{
    qs_match_term term = {.cost = (qs_match_cost)tiny_random(state, 4)};
    term.weight = 1 + tiny_random(state, 3);
    term.truncation = tiny_random(state, 3) == 0 ? 0 : 1 + tiny_random(state, 60);
    if (term.cost == QS_MATCH_SD) { /* two of them would be above 65535 */
        term.truncation = 1 + tiny_random(state, 5000);
    }
    if (term.cost == QS_MATCH_CENSUS) {
        term.width = 3 + 2 * tiny_random(state, 3);
        term.height = 1 + 2 * tiny_random(state, 4);
    }
    return term;
}

static qs_matching random_matching(uint64_t *state)
{
    qs_matching m = pair();
    m.parts = 1 + tiny_random(state, 2);
    m.disparity_min = (int32_t)tiny_random(state, 16) - 12;
    m.disparity_max = m.disparity_min + (int32_t)tiny_random(state, MOST_LABELS);
    m.term_count = 1 + tiny_random(state, 2);
    for (unsigned i = 0; i < m.term_count; i++) {
        m.terms[i] = random_term(state);
    }
    if (m.terms[0].cost == QS_MATCH_CENSUS && m.terms[1].cost == QS_MATCH_CENSUS) {
        m.terms[1].width = m.terms[0].width;
        m.terms[1].height = m.terms[0].height;
    }
    bool keep = m.terms[0].truncation > 0 && tiny_random(state, 2) == 0;
    m.border = keep ? QS_BORDER_KEEP : QS_BORDER_LEAVE_OUT;
    m.x = tiny_random(state, 20);
    m.y = tiny_random(state, HEIGHT);
    m.height = 1 + tiny_random(state, HEIGHT - m.y);
    uint32_t least = 1 + (m.disparity_max > 0 ? (uint32_t)m.disparity_max : 0);
    m.width = least + tiny_random(state, WIDTH - 19 - least);
    m.scale = tiny_random(state, 3) == 0 ? 1000 : 1;
    return m;
}

static void check_row(const qs_matching *m, const qs_problem *p, uint32_t y, const int32_t *least)
{
    for (uint32_t x = 0; x < p->grid.width; x++) {
        int32_t expected = INT32_MAX;
        for (uint32_t d = 0; d < p->labels; d++) {
            size_t at = (size_t)x * p->labels + d;
            int32_t cost = (int32_t)(p->source.bytes == 1 ? ((uint8_t *)row)[at] : row[at]);
            int32_t wanted =
                theta(m, (int)(p->frame.x + x), (int)(p->frame.y + y), m->disparity_min + (int)d) *
                (int32_t)m->scale;
            assert_int_equal(cost + least[x], wanted);
            expected = wanted < expected ? wanted : expected;
        }
        assert_int_equal(least[x], expected);
    }
}

/* The costs of one label for each pixel, any label, are the same. */
static void check_pick(const qs_matching *m, const qs_problem *p, uint32_t y, uint64_t *state)
{
    uint16_t labels[WIDTH];
    int32_t costs[WIDTH];
    for (uint32_t x = 0; x < p->grid.width; x++) {
        labels[x] = (uint16_t)tiny_random(state, p->labels);
    }
    p->source.pick(p->source.context, y, labels, costs);
    for (uint32_t x = 0; x < p->grid.width; x++) {
        int32_t wanted =
            theta(m, (int)(p->frame.x + x), (int)(p->frame.y + y), m->disparity_min + labels[x]);
        assert_int_equal(costs[x], wanted * (int32_t)m->scale);
    }
}

static void costs_are_as_defined(void **unused)
{
    (void)unused;
    int32_t least[WIDTH];
    uint64_t state = 3;
    int in_bytes = 0;
    for (int round = 0; round < 150; round++) {
        qs_problem p;
        draw(&state);
        qs_matching m = random_matching(&state);
        size_t size = qs_matching_workspace(&m);
        assert_in_range(size, 1, sizeof memory);
        memset(memory, 0xA5, sizeof memory);
        assert_int_equal(qs_matching_problem(&m, memory, size, &p), QS_OK);
        int parts = (int)m.parts, from = larger(0, (m.disparity_max + parts - 1) / parts);
        int to = WIDTH - larger(0, (parts - 1 - m.disparity_min) / parts);
        bool all = m.border == QS_BORDER_KEEP;
        int end = (int)(m.x + m.width);
        assert_int_equal(p.frame.x, all ? (int)m.x : larger((int)m.x, from));
        assert_int_equal(p.frame.x + p.grid.width, all ? end : smaller(end, to));
        assert_int_equal(p.frame.first, m.disparity_min);
        assert_int_equal(p.meaning.unit, m.parts == 2 ? 2 : 0);
        assert_int_equal(p.source.bytes == 1, m.scale == 1 && qs_matching_most(&m) <= UINT8_MAX);
        in_bytes += p.source.bytes == 1;
        for (uint32_t y = 0; y < p.grid.height; y++) {
            uint32_t other = tiny_random(&state, p.grid.height);
            p.source.row(p.source.context, y, row, least);
            check_row(&m, &p, y, least);
            check_pick(&m, &p, y, &state);
            check_pick(&m, &p, other, &state);
        }
    }
    assert_in_range(in_bytes, 10, 140);
}

/* Absolute differences alone: both ways make the same problem. */
static void plain_costs_are_those_of_stereo(void **unused)
{
    (void)unused;
    uint64_t state = 17, other_memory[1 << 10];
    for (int round = 0; round < 40; round++) {
        static uint32_t other_row[WIDTH * MOST_LABELS];
        int32_t least[WIDTH], other_least[WIDTH];
        qs_matching m = pair();
        qs_problem a, b;
        draw(&state);
        m.scale = 1 + tiny_random(&state, 3);
        m.disparity_min = (int32_t)tiny_random(&state, 30) - 15;
        m.disparity_max = m.disparity_min + (int32_t)tiny_random(&state, 20);
        m.x = tiny_random(&state, 40);
        m.y = tiny_random(&state, HEIGHT);
        m.width = WIDTH - 40;
        m.height = 1 + tiny_random(&state, HEIGHT - m.y);
        const qs_stereo s = {.left = m.left,
                             .right = m.right,
                             .x = m.x,
                             .y = m.y,
                             .disparity_min = m.disparity_min,
                             .disparity_max = m.disparity_max,
                             .width = m.width,
                             .height = m.height,
                             .scale = m.scale,
                             .weight = m.weight};
        assert_int_equal(qs_matching_problem(&m, memory, sizeof memory, &a), QS_OK);
        assert_int_equal(qs_stereo_problem(&s, other_memory, sizeof other_memory, &b), QS_OK);
        assert_memory_equal(&a.frame, &b.frame, sizeof a.frame);
        assert_int_equal(a.grid.width, b.grid.width);
        assert_int_equal(a.grid.height, b.grid.height);
        assert_int_equal(a.labels, b.labels);
        assert_int_equal(a.source.bytes, b.source.bytes);
        for (uint32_t y = 0; y < a.grid.height; y++) {
            a.source.row(a.source.context, y, row, least);
            b.source.row(b.source.context, y, other_row, other_least);
            assert_memory_equal(row, other_row,
                                (size_t)a.grid.width * a.labels * (size_t)a.source.bytes);
            assert_memory_equal(least, other_least, a.grid.width * sizeof *least);
        }
    }
}

static void weights_follow_contrast(void **unused)
{
    (void)unused;
    uint64_t state = 4;
    for (int round = 0; round < 20; round++) {
        qs_problem p;
        draw(&state);
        qs_matching m = random_matching(&state);
        m.contrast_below = 1 + tiny_random(&state, 60);
        m.contrast_times = 1 + tiny_random(&state, 4);
        assert_int_equal(qs_matching_problem(&m, memory, qs_matching_workspace(&m), &p), QS_OK);
        for (uint32_t y = 0; y < p.grid.height; y++) {
            for (uint32_t x = 0; x < p.grid.width; x++) {
                const uint8_t *at = &left[p.frame.y + y][p.frame.x + x];
                int to_right = at[0] - at[1];
                if (x + 1 < p.grid.width) {
                    bool alike =
                        to_right < (int)m.contrast_below && -to_right < (int)m.contrast_below;
                    assert_int_equal(p.grid.right[y * p.grid.width + x],
                                     alike ? 20 * (int)m.contrast_times : 20);
                }
                if (y + 1 < p.grid.height) {
                    int down = at[0] - at[sizeof left[0]];
                    bool alike = down < (int)m.contrast_below && -down < (int)m.contrast_below;
                    assert_int_equal(p.grid.down[y * p.grid.width + x],
                                     alike ? 20 * (int)m.contrast_times : 20);
                }
            }
        }
    }
}

static void refuses(const qs_matching *m, qs_status why)
{
    qs_problem p, untouched;
    memset(&p, 0x5A, sizeof p);
    untouched = p;
    assert_int_equal(qs_matching_problem(m, memory, sizeof memory, &p), why);
    assert_memory_equal(&p, &untouched, sizeof p);
}

static void refusals(void **unused)
{
    (void)unused;
    qs_problem p;
    qs_matching m = pair();
    size_t size = qs_matching_workspace(&m);
    assert_int_equal(qs_matching_problem(&m, memory, size - 1, &p), QS_E_WORKSPACE);
    assert_int_equal(qs_matching_problem(NULL, memory, size, &p), QS_E_ARGUMENT);
    assert_int_equal(qs_matching_problem(&m, memory, size, &p), QS_OK);
    const struct {
        qs_matching m;
        qs_status why;
    } cases[] = {
#define CASE(why, change) {(m = pair(), (change), m), why}
        CASE(QS_E_ARGUMENT, m.term_count = 0),
        CASE(QS_E_ARGUMENT, m.term_count = 3),
        CASE(QS_E_ARGUMENT, m.parts = 3),
        CASE(QS_E_ARGUMENT, m.parts = 0),
        CASE(QS_E_ARGUMENT, m.scale = 0),
        CASE(QS_E_ARGUMENT, m.weight = -1),
        CASE(QS_E_ARGUMENT, m.terms[0].weight = 0),
        CASE(QS_E_ARGUMENT, m.terms[0].weight = 256),
        CASE(QS_E_ARGUMENT, m.terms[0].width = 3),
        CASE(QS_E_ARGUMENT, m.terms[0].cost = (qs_match_cost)4),
        CASE(QS_E_ARGUMENT, (m.terms[0].cost = QS_MATCH_SD, m.terms[0].weight = 2)),
        CASE(QS_E_ARGUMENT, m.border = QS_BORDER_KEEP), /* without a truncation */
        CASE(QS_E_ARGUMENT, m.disparity_min = 16),
        CASE(QS_E_ARGUMENT, m.contrast_below = 8), /* times nothing */
        CASE(QS_E_ARGUMENT, (m.contrast_below = 257, m.contrast_times = 1)),
        CASE(QS_E_ARGUMENT, m.terms[0] = ((qs_match_term){QS_MATCH_CENSUS, 1, 0, 1, 1})),
        CASE(QS_E_ARGUMENT, m.terms[0] = ((qs_match_term){QS_MATCH_CENSUS, 1, 0, 9, 3})),
        CASE(QS_E_ARGUMENT, m.terms[0] = ((qs_match_term){QS_MATCH_CENSUS, 1, 0, 4, 3})),
        CASE(QS_E_GEOMETRY, m.right.width = WIDTH - 1),
        CASE(QS_E_GEOMETRY, m.disparity_max = WIDTH),
        CASE(QS_E_GEOMETRY, (m.x = 100, m.width = 51, m.height = 1)),
        CASE(QS_E_LIMIT, m.disparity_max = QS_LABELS_MAX),
        CASE(QS_E_OVERFLOW, m.scale = INT32_MAX / 255 + 1),
        CASE(QS_E_OVERFLOW, (m.weight = INT32_MAX / 2, m.contrast_below = 8, m.contrast_times = 3)),
#undef CASE
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        refuses(&cases[i].m, cases[i].why);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(costs_are_as_defined),
        cmocka_unit_test(plain_costs_are_those_of_stereo),
        cmocka_unit_test(weights_follow_contrast),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests_name("matching", tests, NULL, NULL);
}
