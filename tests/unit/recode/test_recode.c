/* Every encoding, over all labels and over those that are left, against all states of tiny problems
 * (docs/MATHS.md). */
#include "recoded.h"

static void one_hot(void **unused)
{
    (void)unused;
    many(1, BITS, any_smoothness, QS_ONE_HOT, QS_PENALTY_LOCAL, true);
    many(2, BITS, any_smoothness, QS_ONE_HOT, QS_PENALTY_MINIMAL, true);
    many(3, BITS, any_smoothness, QS_ONE_HOT, QS_PENALTY_PAPER, true);
}

static void sparse(void **unused)
{
    (void)unused;
    many(4, BITS, potts, QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL, true);
    many(5, BITS, potts, QS_ONE_HOT_SPARSE, QS_PENALTY_PAPER, true);
}

static void minimal_sparse(void **unused)
{
    (void)unused;
    many(6, BITS, potts, QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL, false);
}

static void band_form(void **unused)
{
    (void)unused;
    many(7, BITS, linear, QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL, true);
}

static void minimal_band(void **unused)
{
    (void)unused;
    many(8, BITS, linear, QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL, false);
}

static void walls(void **unused)
{
    (void)unused;
    many(9, BITS, potts, QS_DOMAIN_WALL, QS_PENALTY_LOCAL, false);
    many(10, BITS, linear, QS_DOMAIN_WALL, QS_PENALTY_LOCAL, false);
    many(11, BITS, whole_linear, QS_DOMAIN_WALL, QS_PENALTY_MINIMAL, false);
}

/* Quadratic costs and tables: kappa comes from the values of V. */
static void walls_of_any_cost(void **unused)
{
    (void)unused;
    many(51, BITS, quadratic, QS_DOMAIN_WALL, QS_PENALTY_LOCAL, false);
    many(52, BITS, table, QS_DOMAIN_WALL, QS_PENALTY_LOCAL, false);
    many(53, BITS, whole_quadratic, QS_DOMAIN_WALL, QS_PENALTY_MINIMAL, false);
    many(54, BITS, steep_table, QS_DOMAIN_WALL, QS_PENALTY_LOCAL, false);
}

static void multiway_cut(void **unused)
{
    (void)unused;
    many(12, BITS + 1, potts, QS_MULTIWAY_CUT, QS_PENALTY_LOCAL, false);
    many(13, BITS + 1, potts, QS_MULTIWAY_CUT, QS_PENALTY_PAPER, false);
}

static void st_cut(void **unused)
{
    (void)unused;
    many(14, BITS + 1, whole_linear, QS_ST_CUT, QS_PENALTY_LOCAL, false);
}

/* ---- Repair of what is written. ---- */

static void repair_states(const fixture *f, int64_t gap)
{
    static uint64_t memory[4096];
    size_t size = qs_repair_workspace(&f->index);
    assert_true(size <= sizeof memory);
    for (uint64_t state = 0; state < (uint64_t)1 << f->qubo.variables; state++) {
        uint8_t bits[BYTES];
        uint32_t repaired;
        to_bytes(state, bits);
        int64_t before = qs_qubo_energy(&f->index, bits);
        assert_int_equal(qs_sample_repair(&f->index, bits, memory, size, &repaired), QS_OK);
        assert_int_equal(qs_sample_infeasible(&f->index, bits), 0);
        assert_true(qs_qubo_energy(&f->index, bits) <= before - (repaired > 0 ? gap : 0));
    }
}

/* H falls by the gap in the files that are written, over random label sets. */
static void what_is_written_can_be_repaired(void **unused)
{
    (void)unused;
    static const struct {
        void (*smoothness)(fixture *, uint64_t *);
        qs_encoding encoding;
        qs_penalty penalty;
    } kinds[] = {{any_smoothness, QS_ONE_HOT, QS_PENALTY_LOCAL},
                 {linear, QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL},
                 {linear, QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL},
                 {potts, QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL},
                 {potts, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {linear, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {whole_linear, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {quadratic, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {whole_quadratic, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {table, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {steep_table, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {potts, QS_MULTIWAY_CUT, QS_PENALTY_LOCAL},
                 {whole_linear, QS_ST_CUT, QS_PENALTY_LOCAL},
                 {whole_linear, QS_ST_CUT_ARCS, QS_PENALTY_LOCAL}};
    static fixture f;
    uint64_t state = 41;
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
        for (int round = 0; round < ROUNDS / 5;) {
            int64_t gap = 1 + tiny_random(&state, 3);
            if (random_file(&f, &state, BITS - 2, kinds[kind].smoothness,
                            (qs_encode_options){kinds[kind].encoding, kinds[kind].penalty, 0,
                                                (uint32_t)gap})) {
                repair_states(&f, gap);
                round++;
            }
        }
    }
}

/* Walls whose label sets do not overlap couple nothing, but for the weight that repair asks for. */
static void walls_apart_can_be_repaired(void **unused)
{
    (void)unused;
    static fixture f;
    for (uint64_t first = 1; first < 16; first++) {
        for (uint64_t second = 1; second < 16; second++) {
            make_grid(&f, 2, 1, 4, 5, QS_TRUNCATED_LINEAR);
            memset(f.t.costs, 0, sizeof f.t.costs); /* of which the chains' kappa would come to more
                                                       than the edge costs */
            make_model(&f);
            f.left[0] = first;
            f.left[1] = second;
            assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL}, false),
                             QS_OK);
            repair_states(&f, 1);
        }
    }
}

/* The model of a wall says what every labelling costs, also where V is known up to what belongs to
 * the sites. */
static void walls_have_models(void **unused)
{
    (void)unused;
    static void (*const kinds[])(fixture *, uint64_t *) = {quadratic, whole_quadratic, table,
                                                           steep_table};
    static fixture f;
    static uint64_t memory[MEMORY / 8];
    uint64_t state = 61;
    for (int round = 0; round < ROUNDS;) {
        if (!random_file(&f, &state, BITS, kinds[round % 4],
                         (qs_encode_options){.encoding = QS_DOMAIN_WALL})) {
            continue;
        }
        qs_model model;
        assert_int_equal(qs_model_build(&f.index, memory, sizeof memory, &model), QS_OK);
        for (uint64_t bits = 0; bits < (uint64_t)1 << f.qubo.variables; bits++) {
            uint16_t labelling[TINY_SITES], cells[TINY_SITES] = {0};
            int64_t extra;
            if (!decode(&f, bits, labelling, &extra)) {
                continue;
            }
            for (uint32_t p = 0; p < f.sites; p++) {
                cells[model.width > 0 ? f.cell[p] : p] = labelling[p];
            }
            assert_int_equal(qs_model_energy(&model, cells), problem_energy(&f, labelling));
        }
        round++;
    }
}

/* ---- A variable an arc: given the vertices, each is decided by itself. ---- */

/* H with the arcs' variables at their best; `margin` = the least that any of them would cost at its
 * other value. */
static int64_t best_arcs(const fixture *f, uint32_t vertices, uint64_t state, int64_t *margin)
{
    uint8_t bits[BYTES];
    to_bytes(state, bits);
    int64_t none = qs_qubo_energy(&f->index, bits), best = none;
    *margin = INT64_MAX;
    for (uint32_t z = vertices; z < f->qubo.variables; z++) {
        bits[z / 8] ^= (uint8_t)(1u << z % 8);
        int64_t change = qs_qubo_energy(&f->index, bits) - none,
                size = change < 0 ? -change : change;
        bits[z / 8] ^= (uint8_t)(1u << z % 8);
        best += change < 0 ? change : 0;
        *margin = size < *margin ? size : *margin;
    }
    return best;
}

/* Arcs are coupled with vertices alone, and no run needs weights of its own. */
static void arcs_stand_apart(const fixture *f, uint32_t vertices)
{
    const uint8_t *run = f->qubo.coupling_runs;
    for (uint32_t r = 0; r < f->qubo.coupling_run_count; r++) {
        assert_int_equal(run[8], 0); /* the width */
        run += 36 + (run[4] == 1 ? 8 * (run[24] + 256 * run[25]) : 0);
    }
    for (uint32_t z = vertices; z < f->qubo.groups; z++) {
        for (uint32_t n = f->index.near_start[z]; n < f->index.near_start[z + 1]; n++) {
            assert_true(f->index.near[n].group < vertices);
        }
    }
}

static void check_arcs(const fixture *f, uint32_t vertices, int64_t gap)
{
    uint64_t labellings, found = 0;
    int64_t least = least_energy(f, &labellings), best = INT64_MAX;
    arcs_stand_apart(f, vertices);
    for (uint64_t state = 0; state < (uint64_t)1 << vertices; state++) {
        uint16_t labelling[TINY_SITES];
        int64_t extra, margin, h = best_arcs(f, vertices, state, &margin);
        if (decode(f, state, labelling, &extra)) {
            assert_int_equal(h + extra, problem_energy(f, labelling));
            assert_true(margin >= gap);
            best = h < best ? h : best;
            found++;
        } else {
            assert_true(h >= least + gap);
        }
    }
    assert_int_equal(best, least);
    assert_int_equal(found, labellings);
}

static void st_cut_arcs(void **unused)
{
    (void)unused;
    static fixture f;
    uint64_t state = 15;
    for (int round = 0; round < ROUNDS / 2;) {
        uint32_t gap = 1 + tiny_random(&state, 3), vertices = 2, open = 0;
        if (!random_file(&f, &state, 8 * BYTES, whole_linear,
                         (qs_encode_options){QS_ST_CUT_ARCS, QS_PENALTY_LOCAL, 0, gap})) {
            continue;
        }
        for (uint32_t p = 0; p < f.sites; p++) {
            open += count_labels(&f, p) > 1;
            vertices += count_labels(&f, p) > 1 ? count_labels(&f, p) + 1 : 0;
        }
        if (vertices <= BITS - 1) {
            check_arcs(&f, open > 0 ? vertices : 0, gap);
            round++;
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_hot),
        cmocka_unit_test(sparse),
        cmocka_unit_test(minimal_sparse),
        cmocka_unit_test(band_form),
        cmocka_unit_test(minimal_band),
        cmocka_unit_test(walls),
        cmocka_unit_test(walls_of_any_cost),
        cmocka_unit_test(walls_have_models),
        cmocka_unit_test(multiway_cut),
        cmocka_unit_test(st_cut),
        cmocka_unit_test(what_is_written_can_be_repaired),
        cmocka_unit_test(walls_apart_can_be_repaired),
        cmocka_unit_test(st_cut_arcs),
    };
    return cmocka_run_group_tests_name("recode", tests, NULL, NULL);
}
