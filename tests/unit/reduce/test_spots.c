/* Windows that are cut out of tiny grids and searched, beside all labellings. */
#include "tiny.h"

#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "problem/pairwise.h"
#include "reduce/parts.h"
#include "reduce/spots.h"
#include "stopping.h"
#include "wide_grid.h"

enum {
    ROUNDS = 4000,
    WIDE_ROUNDS = 600,
    SITES = COLUMNS * ROWS,
    LABELS = WIDE_LABELS,
    LABELLINGS = 1 << 13,
    FINEST = 14,
    MEMORY = 1 << 17,
    WORK = 1 << 21
};

typedef struct grid {
    qs_model model;
    int32_t unary[SITES * LABELS], right[SITES], down[SITES], table[LABELS * LABELS];
} grid;

static grid g;
static qs_elimination sets;
static uint8_t kept[SITES * LABELS];
static uint16_t labelling[SITES];
static uint64_t set_memory[MEMORY / 8], spot_memory[MEMORY / 8], memory[WORK / 8];
static int32_t padded[4 * SITES * LABELS], scratch[16 * LABELS];
static int64_t shares[SITES], energies[LABELLINGS];

static uint32_t count_labellings(uint32_t sites, uint32_t labels)
{
    uint32_t all = 1;
    for (uint32_t p = 0; p < sites && all <= LABELLINGS; p++) {
        all *= labels;
    }
    return all;
}

/* All of V: of tables any costs, not even symmetric. */
static void make_pairwise(uint64_t *state)
{
    static const qs_smoothness all[] = {QS_POTTS, QS_TABLE, QS_TRUNCATED_LINEAR,
                                        QS_TRUNCATED_QUADRATIC, QS_TABLE};
    qs_model *m = &g.model;
    m->pairwise.smoothness = all[tiny_random(state, 5)];
    m->pairwise.truncation = tiny_random(state, 2) ? 1 + tiny_random(state, 4) : 0;
    m->pairwise.table = m->pairwise.smoothness == QS_TABLE ? g.table : NULL;
    m->pairwise_max = 0;
    for (uint32_t i = 0; i < m->labels * m->labels; i++) {
        g.table[i] = (int32_t)tiny_random(state, 9);
    }
    for (uint32_t i = 0; i < m->labels * m->labels; i++) {
        int64_t value = qs_pairwise_value(&m->pairwise, m->labels, i / m->labels, i % m->labels);
        m->pairwise_max = value > m->pairwise_max ? value : m->pairwise_max;
    }
}

/* Some edges are none, so that grids have parts. */
static int32_t weight_of(uint64_t *state, uint32_t most)
{
    return tiny_random(state, 4) > 0 ? 1 + (int32_t)tiny_random(state, most) : 0;
}

static void make(uint64_t *state)
{
    qs_model *m = &g.model;
    do {
        *m = (qs_model){.width = 1 + tiny_random(state, 5), .height = 1 + tiny_random(state, 5)};
        m->sites = m->width * m->height;
        m->labels = 2 + tiny_random(state, tiny_random(state, 2) ? 3 : LABELS - 1);
    } while (m->sites > SITES || m->width * m->height < 4 ||
             count_labellings(m->sites, m->labels) > LABELLINGS);
    m->constant = 7;
    m->unary = g.unary;
    m->right = g.right;
    m->down = g.down;
    make_pairwise(state);
    uint32_t costs = 2 + tiny_random(state, tiny_random(state, 2) ? 3 : 12),
             weights = 1 + tiny_random(state, 4);
    for (uint32_t p = 0; p < m->sites; p++) {
        g.right[p] = (p + 1) % m->width != 0 ? weight_of(state, weights) : 0;
        g.down[p] = p + m->width < m->sites ? weight_of(state, weights) : 0;
        for (uint32_t d = 0; d < m->labels; d++) {
            g.unary[p * m->labels + d] = (int32_t)tiny_random(state, costs);
        }
    }
}

/* What each labelling costs. Returns the least. */
static int64_t find_energies(void)
{
    int64_t least = INT64_MAX;
    uint32_t all = count_labellings(g.model.sites, g.model.labels);
    for (uint32_t i = 0; i < all; i++) {
        uint16_t x[SITES];
        for (uint32_t p = 0, rest = i; p < g.model.sites; p++, rest /= g.model.labels) {
            x[p] = (uint16_t)(rest % g.model.labels);
        }
        energies[i] = qs_model_energy(&g.model, x);
        least = energies[i] < least ? energies[i] : least;
    }
    return least;
}

/* No label of an optimum has left. In closed parts one optimum is enough, with other labels there.
 */
static void check_kept(int64_t least)
{
    uint32_t all = count_labellings(g.model.sites, g.model.labels);
    for (uint32_t i = 0; i < all; i++) {
        for (uint32_t p = 0, rest = i; energies[i] == least && p < g.model.sites;
             p++, rest /= g.model.labels) {
            assert_true(kept[p * g.model.labels + rest % g.model.labels]);
        }
    }
}

/* The label sets, a labelling at hand, and messages of some iterations. */
static qs_trws_state begin(uint64_t *state)
{
    qs_arena arena = {.base = (char *)set_memory};
    qs_eliminate_take(&sets, &g.model, &arena);
    assert_true(qs_arena_size(&arena) <= sizeof set_memory);
    qs_eliminate_lay(&sets, &g.model, false, kept, labelling);
    for (uint32_t p = 0; p < g.model.sites; p++) {
        labelling[p] = (uint16_t)tiny_random(state, g.model.labels);
    }
    if (tiny_random(state, 2)) {
        qs_solution ended;
        assert_int_equal(qs_icm(&g.model, NULL, NULL, 0, labelling, &ended), QS_OK);
    }
    qs_eliminate_begin(&sets);
    memset(padded, 0, sizeof padded);
    qs_trws_state s = {.model = &sets.model,
                       .messages = padded + qs_trws_padding(&sets.model),
                       .scratch = scratch,
                       .wide = qs_lanes_avx2()};
    assert_true(qs_scale_choose(&sets.model, FINEST, &s.scale));
    qs_trws_iterate(&s, tiny_random(state, 3));
    return s;
}

/* Some parts may be closed before. */
static bool close_parts(uint64_t *state)
{
    qs_allowance work = {tiny_random(state, 4) > 0 ? 0 : 1 << 14, NULL};
    if (work.left > 0 && qs_parts_solve(&sets, memory, sizeof memory, &work, NULL)) {
        qs_eliminate_restore(&sets);
        return true;
    }
    return false;
}

typedef struct tally {
    uint32_t searched, left, proven;
} tally;

/* One call. Energies of what is left stay, the bound holds, and messages are in order. */
static void search(qs_trws_state *s, uint64_t *state, int64_t least, tally *t)
{
    qs_spots spots;
    qs_arena arena = {.base = (char *)spot_memory};
    qs_spots_take(&spots, &g.model, &arena);
    assert_true(qs_arena_size(&arena) <= sizeof spot_memory);
    memset(spot_memory, 0xa5, sizeof spot_memory);
    qs_look look = look_that_stops_after(tiny_random(state, QS_BETWEEN_LOOKS));
    qs_allowance work = {tiny_random(state, 3) > 0 ? UINT64_MAX : tiny_random(state, 100000),
                         tiny_random(state, 4) > 0 ? NULL : &look};
    size_t size = tiny_random(state, 8) > 0 ? sizeof memory : 20000;
    qs_spots_call call = {&sets, s, 1 + tiny_random(state, 4), memory, size, shares, &work};
    int64_t gap, before = qs_model_energy(&sets.model, labelling);
    bool done = qs_spots_take_out(&spots, &call, &gap);
    int64_t energy = qs_model_energy(&sets.model, labelling);
    assert_true(energy <= before && energy >= least);
    assert_int_equal(energy, qs_model_energy(&g.model, labelling));
    for (uint32_t i = 0; i < spots.saved_count; i++) {
        assert_memory_equal(s->messages + spots.edges[i], spots.saved + i * g.model.labels,
                            g.model.labels * sizeof *spots.saved);
    }
    for (uint32_t i = 0; i < qs_trws_padding(&g.model); i++) {
        assert_int_equal(padded[i], 0);
    }
    if (done) {
        uint32_t variables = (uint32_t)sets.variables;
        assert_true(gap >= 0 && energy - gap <= least);
        qs_eliminate_follow(&sets);
        qs_trws_visit_only(s, sets.left, sets.left_count);
        t->searched++;
        t->left += sets.variables < variables;
        t->proven += energy - gap == least && energy == least;
    }
    assert_true(qs_model_energy(&sets.model, labelling) <= energy);
    assert_int_equal(qs_model_energy(&sets.model, labelling), qs_model_energy(&g.model, labelling));
}

static void bounds_hold(void **unused)
{
    (void)unused;
    uint64_t state = 91;
    tally t = {0};
    for (int round = 0; round < ROUNDS; round++) {
        make(&state);
        int64_t least = find_energies();
        qs_trws_state s = begin(&state);
        bool closed = false;
        for (int times = 0; times < 3; times++) {
            closed |= close_parts(&state);
            search(&s, &state, least, &t);
            if (!closed) {
                check_kept(least);
            }
            qs_trws_iterate(&s, tiny_random(&state, 3));
        }
    }
    print_message("searched %u, labels left %u, proven %u of %d\n", t.searched, t.left, t.proven,
                  3 * ROUNDS);
    assert_true(t.searched > ROUNDS / 2 && t.left > ROUNDS / 3 && t.proven > ROUNDS / 3);
}

/* Larger grids, which are harder: their bounds stay below. Of the labels that have left some are
 * looked at. */
static void wide_bounds_hold(void **unused)
{
    (void)unused;
    uint64_t state = 93;
    tally t = {0};
    for (int round = 0; round < WIDE_ROUNDS; round++) {
        static wide_grid w;
        make_wide(&w, &state);
        g.model = w.model;
        int64_t least = least_with(&w, w.model.sites, 0);
        qs_trws_state s = begin(&state);
        search(&s, &state, least, &t);
        search(&s, &state, least, &t);
        for (int i = 0; i < 20; i++) {
            uint32_t p = tiny_random(&state, w.model.sites), d = tiny_random(&state, WIDE_LABELS);
            assert_true(kept[p * WIDE_LABELS + d] || least_with(&w, p, d) > least);
        }
    }
    print_message("searched %u, labels left %u, proven %u of %d\n", t.searched, t.left, t.proven,
                  2 * WIDE_ROUNDS);
    assert_true(t.searched > WIDE_ROUNDS / 4 && t.proven > WIDE_ROUNDS / 8);
}

/* A whole grid as a window, with any labelling and any messages to begin with. */
static void searches_find_the_least(void **unused)
{
    (void)unused;
    uint64_t state = 92;
    uint32_t proven = 0, gained = 0;
    for (int round = 0; round < 2 * WIDE_ROUNDS; round++) {
        static wide_grid w;
        qs_block b;
        make_wide(&w, &state);
        g.model = w.model;
        qs_trws_state s = begin(&state);
        qs_rectangle all = {0, 0, g.model.width, g.model.height};
        assert_true(qs_block_take(&b, &sets.model, all, memory, sizeof memory));
        assert_true(qs_block_hold(&b, &sets.model, labelling));
        int64_t held = qs_model_energy(&sets.model, labelling) - b.energy;
        int64_t least = least_with(&w, w.model.sites, 0) - held;
        b.state.scale = s.scale;
        memcpy(b.state.messages - qs_trws_padding(&b.model), padded,
               sizeof *padded * (qs_trws_padding(&b.model) + qs_trws_messages(&b.model)));
        int64_t unit = (int64_t)1 << s.scale.shift;
        bool enough = tiny_random(&state, 3) > 0;
        qs_allowance work = {enough ? UINT64_MAX : 1 + tiny_random(&state, 1000000), NULL};
        int64_t before = b.energy, bound = qs_window_search(&b, unit, &work);
        assert_true(bound <= least * unit && b.energy >= least);
        assert_int_equal(qs_model_energy(&g.model, b.labelling), b.energy + held);
        if (enough) {
            assert_true(b.energy == least && bound > (least - 1) * unit);
            proven++;
        }
        gained += b.energy < before;
    }
    print_message("proven %u, gained %u of %d\n", proven, gained, 2 * WIDE_ROUNDS);
    assert_true(proven > WIDE_ROUNDS && gained > WIDE_ROUNDS / 8);
}

/* Along two rows edges get heavier and heavier. Labels close these in a window whose neighbours are
 * held, and what is left of it has finer messages than the whole window has room for: the sanitizer
 * sees a number that does not fit. */
static void heavy_edges_fit(void **unused)
{
    (void)unused;
    enum { WIDTH = 57, HEIGHT = 55, FEW = 5, CELLS = WIDTH * HEIGHT, LIGHT = 14, HEAVY = 8000000 };
    static int32_t unary[CELLS * FEW], right[CELLS], down[CELLS];
    static uint16_t found[CELLS];
    uint64_t state = 97;
    qs_model m = {.sites = CELLS, .labels = FEW, .pairwise_max = 1};
    m.width = WIDTH;
    m.height = HEIGHT;
    m.unary = unary;
    m.right = right;
    m.down = down;
    for (uint32_t p = 0; p < CELLS; p++) {
        right[p] = (p + 1) % WIDTH != 0 ? LIGHT : 0;
        down[p] = p + WIDTH < CELLS ? LIGHT : 0;
        for (uint32_t d = 0; d < FEW; d++) {
            unary[p * FEW + d] = (int32_t)tiny_random(&state, 16 * LIGHT / 5);
        }
    }
    for (int row = 0; row < 2; row++) {
        uint32_t p = WIDTH * (5 + tiny_random(&state, HEIGHT - 10)) + 10;
        for (int32_t weight = HEAVY; weight > LIGHT; weight = weight / 100 * 49) {
            right[p++] = weight;
        }
    }
    size_t size = qs_best_workspace(&m);
    void *workspace = malloc(size);
    assert_non_null(workspace);
    const qs_solve_options options = {.iterations = 270};
    qs_solution solution;
    assert_int_equal(qs_best(&m, &options, workspace, size, found, &solution), QS_OK);
    assert_int_equal(solution.energy, qs_model_energy(&m, found));
    assert_true(solution.lower_bound <= solution.energy);
    free(workspace);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heavy_edges_fit),
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(wide_bounds_hold),
        cmocka_unit_test(searches_find_the_least),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
