/* Reductions of grids that are too large to try all labellings: when they stop, when they go on,
 * and what they visit. */
#include "tiny.h"

#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "solve/trws.h"
#include "wide_grid.h"

enum { ROUNDS = 200, WORK = 1 << 23 };

static uint64_t memory[WORK / 8];

static void no_optimum_of_larger_grids_is_lost(void **unused)
{
    (void)unused;
    static wide_grid g;
    uint64_t state = 39;
    uint32_t gone = 0, more = 0;
    for (int round = 0; round < 12; round++) {
        uint8_t kept[COLUMNS * ROWS * WIDE_LABELS];
        uint16_t labelling[COLUMNS * ROWS];
        qs_reduction r;
        make_wide(&g, &state);
        assert_true(qs_reduce_workspace(&g.model) <= sizeof memory);
        assert_int_equal(qs_reduce(&g.model, NULL, memory, sizeof memory, kept, labelling, &r),
                         QS_OK);
        int64_t minimum = least_with(&g, g.model.sites, 0);
        assert_true(r.lower_bound <= minimum && minimum <= r.upper_bound);
        for (uint32_t i = 0; i < g.model.sites * WIDE_LABELS; i++) {
            if (kept[i]) {
                more += least_with(&g, i / WIDE_LABELS, i % WIDE_LABELS) > minimum;
            } else if (tiny_random(&state, 4) == 0) {
                assert_true(least_with(&g, i / WIDE_LABELS, i % WIDE_LABELS) > minimum);
                gone++;
            }
        }
    }
    print_message("labels kept that are in no optimum: %u\n", more);
    assert_true(gone > 100 && more < 10);
}

static bool until(void *context, const qs_reduction *so_far)
{
    return so_far->iterations < *(const uint64_t *)context;
}

/* Whoever loses patience gets what has been proven until then: nearly as much as at the end of so
 * many iterations, which ends with one labelling more. */
static void stopped_is_nearly_as_good_as_ended(void **unused)
{
    (void)unused;
    static wide_grid g;
    uint64_t state = 45, left[2] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t kept[COLUMNS * ROWS * WIDE_LABELS];
        uint16_t labelling[COLUMNS * ROWS];
        make_wide(&g, &state);
        for (int i = 0; i < 2; i++) {
            uint64_t last = 2 + (uint64_t)round % 5;
            qs_reduce_options options = {
                .iterations = i ? last : 0, .watch = i ? NULL : until, .context = &last};
            qs_reduction r;
            assert_int_equal(
                qs_reduce(&g.model, &options, memory, sizeof memory, kept, labelling, &r), QS_OK);
            assert_int_equal(qs_model_energy(&g.model, labelling), r.upper_bound);
            left[i] += r.variables;
        }
    }
    print_message("variables where stopped %d, where ended %d\n", (int)left[0], (int)left[1]);
    assert_true(left[0] < 2 * left[1]);
}

static bool until_proven(void *context, const qs_reduction *so_far)
{
    (void)context;
    return so_far->lower_bound < so_far->upper_bound;
}

/* After the proof it goes on for fewer labels: within the limit of iterations, and until the watch
 * has had enough. */
static void after_the_proof(void **unused)
{
    (void)unused;
    static wide_grid g;
    uint64_t state = 46, whole = 0, stopped = 0;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t kept[COLUMNS * ROWS * WIDE_LABELS];
        uint16_t labelling[COLUMNS * ROWS];
        qs_reduction r, s, t;
        make_wide(&g, &state);
        assert_int_equal(qs_reduce(&g.model, NULL, memory, sizeof memory, kept, labelling, &r),
                         QS_OK);
        qs_reduce_options options = {.watch = until_proven};
        assert_int_equal(qs_reduce(&g.model, &options, memory, sizeof memory, kept, labelling, &s),
                         QS_OK);
        options = (qs_reduce_options){.iterations = r.iterations > 1 ? r.iterations - 1 : 1};
        assert_int_equal(qs_reduce(&g.model, &options, memory, sizeof memory, kept, labelling, &t),
                         QS_OK);
        assert_true(s.iterations <= r.iterations && t.iterations <= options.iterations);
        whole += r.iterations;
        stopped += s.iterations;
    }
    print_message("iterations %d, where stopped at the proof %d\n", (int)whole, (int)stopped);
    assert_true(stopped < whole - whole / 20);
}

/* Passes over some sites only, the others without edges: wide, plain and over all sites they do the
 * same. */
static void visits_leave_nothing_out(void **unused)
{
    (void)unused;
    static wide_grid g;
    static int32_t messages[3][4 * COLUMNS * ROWS * WIDE_LABELS], scratch[4 * WIDE_LABELS + 64];
    uint64_t state = 40;
    for (int round = 0; round < ROUNDS; round++) {
        uint32_t visits[COLUMNS * ROWS], count = 0;
        int64_t bounds[3] = {0};
        make_wide(&g, &state);
        for (uint32_t p = 0; p < g.model.sites; p++) {
            if (tiny_random(&state, 3) == 0) { /* one label, no edges */
                memset(g.unary + p * WIDE_LABELS, 0, sizeof *g.unary * WIDE_LABELS);
                g.right[p] = g.down[p] = 0;
                g.right[p > 0 ? p - 1 : p] = g.down[p >= COLUMNS ? p - COLUMNS : p] = 0;
            } else {
                visits[count++] = p;
            }
        }
        for (int way = 0; way < 3; way++) {
            size_t padding = (size_t)qs_trws_padding(&g.model);
            qs_trws_state s = {.model = &g.model,
                               .wide = way == 1 && qs_lanes_avx2(),
                               .messages = messages[way] + padding,
                               .scratch = scratch};
            assert_true(qs_scale_choose(&g.model, 14, &s.scale));
            assert_true(padding + qs_trws_messages(&g.model) <=
                            sizeof messages[0] / sizeof *messages[0] &&
                        qs_trws_scratch(&g.model) <= 4 * WIDE_LABELS + 64);
            memset(messages[way], 0, sizeof messages[way]);
            for (uint32_t i = 0; i < 2 * g.model.sites * WIDE_LABELS; i++) {
                s.messages[i] = (int32_t)i % 5 << s.scale.shift;
            }
            qs_trws_visit_only(&s, visits, count);
            s.visits = way < 2 ? visits : NULL;
            for (int i = 0; i < 7; i++) {
                bounds[way] += qs_trws_grid_pass(&s, i % 2 == 0);
            }
        }
        assert_true(bounds[0] == bounds[1] && bounds[1] == bounds[2]);
        assert_memory_equal(messages[0], messages[1], sizeof messages[0]);
        assert_memory_equal(messages[0], messages[2], sizeof messages[0]);
    }
}

/* Noise on a grid whose bound stalls 1 below the optimum. Messages that begin anew on what is left
 * close the gap. */
static void stalls_are_overcome(void **unused)
{
    (void)unused;
    enum { SIDE = 20, CELLS = SIDE * SIDE, FOUR = 4, NOISE = 20, WEIGHT = 4, SEED = 23 };
    static int32_t unary[CELLS * FOUR], right[CELLS], down[CELLS];
    static uint8_t kept[CELLS * FOUR];
    static uint16_t labelling[CELLS];
    uint64_t state = SEED;
    for (uint32_t p = 0; p < CELLS; p++) {
        int32_t *costs = unary + FOUR * p, least = NOISE;
        right[p] = (p + 1) % SIDE != 0 ? WEIGHT : 0;
        down[p] = p + SIDE < CELLS ? WEIGHT : 0;
        for (int d = 0; d < FOUR; d++) {
            costs[d] = (int32_t)tiny_random(&state, NOISE);
            least = costs[d] < least ? costs[d] : least;
        }
        for (int d = 0; d < FOUR; d++) {
            costs[d] -= least;
        }
    }
    qs_model model = {.sites = CELLS,
                      .labels = FOUR,
                      .width = SIDE,
                      .height = SIDE,
                      .unary = unary,
                      .right = right,
                      .down = down,
                      .pairwise = {QS_TRUNCATED_LINEAR, 2, NULL},
                      .pairwise_max = 2};
    size_t size = qs_reduce_workspace(&model);
    void *work = malloc(size);
    assert_non_null(work);
    qs_reduction r;
    assert_int_equal(qs_reduce(&model, NULL, work, size, kept, labelling, &r), QS_OK);
    assert_int_equal(r.upper_bound, qs_model_energy(&model, labelling));
    assert_int_equal(r.lower_bound, r.upper_bound);
    for (uint32_t p = 0; p < CELLS; p++) {
        assert_true(kept[FOUR * p + labelling[p]]);
    }
    free(work);
}

/* What Goldstein's criterion folds raises costs beyond those that moves can work with in 32 bits,
 * so that they would take more memory: then there are no moves. */
static void costs_that_grow_leave_moves_out(void **unused)
{
    (void)unused;
    static const int32_t costs[] = {
        183700008, 138651970, 130097421, 199736876, 98433979,  156872264, 16859780,  181050016,
        29659338,  115583741, 251236647, 97423683,  221165180, 68561889,  261306184, -2000000};
    static const int32_t right[] = {24627335, 29552802, 39403736, 0}, down[4] = {0};
    const qs_problem problem = {.labels = 4,
                                .scale = 1,
                                .pairwise = {.smoothness = QS_TRUNCATED_LINEAR},
                                .grid = {.width = 4, .height = 1, .right = right, .down = down},
                                .costs = costs};
    static uint64_t laid_out[1 << 14];
    qs_model model;
    uint8_t kept[16];
    uint16_t labelling[4];
    qs_reduction r;
    assert_int_equal(qs_model_of_problem(&problem, laid_out, sizeof laid_out, &model, NULL), QS_OK);
    size_t size = qs_reduce_workspace(&model);
    void *work = malloc(size); /* of that very size: the sanitizer sees a byte too many */
    assert_non_null(work);
    assert_int_equal(qs_reduce(&model, NULL, work, size, kept, labelling, &r), QS_OK);
    assert_int_equal(r.upper_bound, tiny_minimum(&problem));
    assert_int_equal(r.lower_bound, r.upper_bound);
    free(work);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_optimum_of_larger_grids_is_lost),
        cmocka_unit_test(stopped_is_nearly_as_good_as_ended),
        cmocka_unit_test(after_the_proof),
        cmocka_unit_test(visits_leave_nothing_out),
        cmocka_unit_test(stalls_are_overcome),
        cmocka_unit_test(costs_that_grow_leave_moves_out),
    };
    return cmocka_run_group_tests_name("reduce, grids", tests, NULL, NULL);
}
