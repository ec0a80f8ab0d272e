/* Windows of grids with their neighbours held, beside all labellings of the window. */
#include "stopping.h"
#include "tiny.h"

#include <string.h>

#include "reduce/block.h"
#include "reduce/windows.h"

enum { ROUNDS = 1500, BITS = 18, MEMORY = 1 << 16, WORK = 1 << 21 };

static tiny t;
static tiny_qubo q;
static uint64_t model_memory[MEMORY / 8], set_memory[MEMORY / 8], memory[WORK / 8];
static qs_model model;
static qs_elimination sets;
static uint8_t kept[TINY_SITES * TINY_LABELS];
static uint16_t labelling[TINY_SITES];

/* A grid with the label sets that Goldstein's criterion leaves, and any labelling of these. */
static void make(uint64_t *state)
{
    do {
        tiny_make(&t, state, BITS, tiny_random(state, 2));
    } while (t.problem.grid.width == 0);
    tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 0}, &q);
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model), QS_OK);
    qs_arena arena = {.base = (char *)set_memory};
    qs_eliminate_take(&sets, &model, &arena);
    assert_true(qs_arena_size(&arena) <= sizeof set_memory);
    qs_eliminate_lay(&sets, &model, false, kept, labelling);
    qs_model_winner(&model, labelling);
    qs_eliminate_begin(&sets);
    for (uint32_t p = 0; p < model.sites; p++) {
        do {
            labelling[p] = (uint16_t)tiny_random(state, model.labels);
        } while (!kept[p * model.labels + labelling[p]]);
    }
}

static qs_rectangle any_window(uint64_t *state)
{
    qs_rectangle at = {tiny_random(state, model.width), tiny_random(state, model.height), 0, 0};
    at.width = 1 + tiny_random(state, model.width - at.x);
    at.height = 1 + tiny_random(state, model.height - at.y);
    return at;
}

/* The next labelling of kept labels of a window's sites; false after the last. */
static bool step(const qs_block *b, uint16_t *whole)
{
    for (uint32_t c = 0; c < b->model.sites; c++) {
        uint32_t p = qs_block_site(b, &sets.model, c);
        for (uint16_t d = (uint16_t)(whole[p] + 1); d < model.labels; d++) {
            if (kept[p * model.labels + d]) {
                whole[p] = d;
                return true;
            }
        }
        for (whole[p] = 0; !kept[p * model.labels + whole[p]]; whole[p]++) {
        }
    }
    return false;
}

/* What the window gains the whole gains, whatever its labels. Returns the least energy. */
static int64_t check_all(const qs_block *b)
{
    uint16_t whole[TINY_SITES], inside[TINY_SITES];
    int64_t least = INT64_MAX, held = qs_model_energy(&sets.model, labelling) - b->energy;
    memcpy(whole, labelling, sizeof whole);
    for (uint32_t c = 0; c < b->model.sites; c++) {
        uint32_t p = qs_block_site(b, &sets.model, c);
        for (whole[p] = 0; !kept[p * model.labels + whole[p]]; whole[p]++) {
        }
    }
    do {
        for (uint32_t c = 0; c < b->model.sites; c++) {
            inside[c] = whole[qs_block_site(b, &sets.model, c)];
        }
        int64_t energy = qs_model_energy(&b->model, inside);
        assert_int_equal(energy + held, qs_model_energy(&sets.model, whole));
        least = energy < least ? energy : least;
    } while (step(b, whole));
    return least;
}

static void windows_are_solved(void **unused)
{
    (void)unused;
    uint64_t state = 61;
    uint32_t solved = 0;
    for (int round = 0; round < ROUNDS; round++) {
        qs_block b;
        make(&state);
        assert_true(qs_block_take(&b, &sets.model, any_window(&state), memory, sizeof memory));
        memset(memory, 0xa5, sizeof memory);
        if (!qs_block_hold(&b, &sets.model, labelling)) {
            continue;
        }
        int64_t before = b.energy, least = check_all(&b);
        qs_block_solve(&b, NULL);
        assert_true(b.energy <= before && b.bound <= least);
        assert_int_equal(qs_model_energy(&b.model, b.labelling), b.energy);
        for (uint32_t c = 0; c < b.model.sites; c++) {
            assert_true(b.kept[c * model.labels + b.labelling[c]]);
        }
        assert_true(b.energy >= least);
        solved += b.energy == least && b.bound == least;
    }
    print_message("solved %u of %d\n", solved, ROUNDS);
    assert_true(solved > ROUNDS * 99 / 100);
}

/* All windows in turn, with little memory at times, and stopped early at times. */
static void rounds_never_rise(void **unused)
{
    (void)unused;
    uint64_t state = 62;
    uint32_t gained = 0, stopped = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        int64_t before = qs_model_energy(&sets.model, labelling);
        qs_look look = look_that_stops_after(tiny_random(&state, 2000));
        bool patient = tiny_random(&state, 3) > 0;
        size_t size = tiny_random(&state, 3) ? sizeof memory : tiny_random(&state, 20000);
        qs_rectangle first = {0, 0, 1 + tiny_random(&state, 3), 1 + tiny_random(&state, 3)};
        first.x = tiny_random(&state, first.width);
        first.y = tiny_random(&state, first.height);
        int64_t gain =
            qs_windows_improve(&sets, first, labelling, memory, size, patient ? NULL : &look);
        stopped += look.stopped;
        assert_true(gain >= 0);
        assert_int_equal(qs_model_energy(&sets.model, labelling), before - gain);
        for (uint32_t p = 0; p < model.sites; p++) {
            assert_true(kept[p * model.labels + labelling[p]]);
        }
        gained += gain > 0;
    }
    print_message("gained %u of %d, stopped %u\n", gained, ROUNDS, stopped);
    assert_true(gained > ROUNDS / 5 && stopped > ROUNDS / 9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(windows_are_solved),
        cmocka_unit_test(rounds_never_rise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
