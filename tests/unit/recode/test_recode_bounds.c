/* Counts, bounds that are the least, the paper's example, and the bytes of recoded files. */
#include "recoded.h"

#include "base/sort.h"

/* ---- Counts. ---- */

static void check_counts(fixture *f, qs_encoding encoding, uint64_t variables, uint64_t terms)
{
    qs_qubo_summary summary;
    assert_int_equal(recode(f, (qs_encode_options){.encoding = encoding}, false), QS_OK);
    qs_qubo_summarise(&f->qubo, &summary);
    assert_int_equal(f->qubo.variables, variables);
    assert_int_equal(summary.quadratic_terms, terms);
}

/* The formulas of the paper's Table 1, and docs/MATHS.md's couplers an edge. */
static void counts_by_formula(void **unused)
{
    (void)unused;
    static fixture f;
    static const struct {
        uint32_t n, m, k;
    } cases[] = {{1, 1, 3}, {2, 1, 2}, {3, 2, 2}, {2, 2, 4}, {4, 3, 3}, {1, 5, 5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint64_t n = cases[i].n, m = cases[i].m, k = cases[i].k, edges = 2 * n * m - n - m;
        make_grid(&f, cases[i].n, cases[i].m, cases[i].k, 7, QS_POTTS);
        check_counts(&f, QS_ONE_HOT, n * m * k, n * m * k * (k - 1) / 2 + edges * k * (k - 1));
        check_counts(&f, QS_ONE_HOT_SPARSE, n * m * k, n * m * k * (k - 1) / 2 + edges * k);
        check_counts(&f, QS_DOMAIN_WALL, n * m * (k - 1), n * m * (k - 2) + edges * (3 * k - 5));
        check_counts(&f, QS_MULTIWAY_CUT, n * m * k + k * k,
                     n * m * k * (k - 1) / 2 + edges * k * (k - 1) + k * k * (k - 1) / 2 +
                         n * m * k * k * (k - 1));
        make_grid(&f, cases[i].n, cases[i].m, cases[i].k, 7, QS_TRUNCATED_LINEAR);
        check_counts(&f, QS_DOMAIN_WALL, n * m * (k - 1), n * m * (k - 2) + edges * (k - 1));
        check_counts(&f, QS_ST_CUT, n * m * k + n * m + 2, n * m * (k + 2) + (k + 1) * edges);
        check_counts(&f, QS_ST_CUT_ARCS,
                     7 * n * m * k + 9 * n * m - 2 * n * k - 2 * m * k - 2 * n - 2 * m + 2,
                     5 * (n * m * (k + 2) + (k + 1) * edges));
        f.t.problem.pairwise.truncation = 2;
        make_model(&f);
        check_counts(&f, QS_DOMAIN_WALL, n * m * (k - 1),
                     n * m * (k - 2) + edges * (k - 1 + (k > 3 ? 2 * (k - 3) : 0)));
    }
}

/* ---- Bounds that are the least. ---- */

/* The least H of all states less min F where each penalty is `less` units smaller: `broken` says
 * how many units of penalty a state pays. */
static int64_t margin(const fixture *f, int64_t less, int64_t (*broken)(const fixture *, uint64_t))
{
    uint64_t labellings;
    int64_t least = least_energy(f, &labellings), lowest = INT64_MAX;
    for (uint64_t state = 0; state < (uint64_t)1 << f->qubo.variables; state++) {
        uint16_t labelling[TINY_SITES];
        int64_t extra, h = energy_of(f, state) - less * broken(f, state);
        if (!decode(f, state, labelling, &extra)) {
            lowest = h < lowest ? h : lowest;
        }
    }
    return lowest - least;
}

/* Up-steps of the walls of all sites, which have all labels. */
static int64_t up_steps(const fixture *f, uint64_t state)
{
    uint32_t variables = f->t.problem.labels - 1;
    int64_t steps = 0;
    for (uint32_t p = 0; p < f->sites; p++) {
        for (uint32_t i = 1; i < variables; i++) {
            steps += (state >> (variables * p + i - 1) & 3) == 2;
        }
    }
    return steps;
}

/* Writes walls with kappa as it must be and a gap of 1: the up-steps reach 0 with the gap gone, and
 * neither before nor behind that. */
static void assert_walls_are_tight(fixture *f)
{
    make_model(f);
    assert_int_equal(recode(f, (qs_encode_options){.encoding = QS_DOMAIN_WALL, .gap = 1}, false),
                     QS_OK);
    assert_int_equal(margin(f, 1, up_steps), 0);
    assert_true(margin(f, 0, up_steps) > 0);
    assert_true(margin(f, 2, up_steps) < 0);
}

/* Costs (0, t, 0): at kappa = t + W every site in the pattern u = (0, 1) together reach 0. */
static void wall_bounds_are_tight(void **unused)
{
    (void)unused;
    static fixture f;
    for (uint32_t width = 2; width <= 3; width++) {
        make_grid(&f, width, 2, 3, 10, QS_POTTS);
        for (uint32_t i = 0; i < width * 2 * 3; i++) {
            f.t.costs[i] = i % 3 == 1 ? 25 : 0;
        }
        assert_walls_are_tight(&f);
    }
}

/* Labels of unlike parity cost 1 on an edge, and t at their site. At kappa = t + W (n - 1) / 2 + W
 * / 2, for n labels, every site in the pattern u = (0, 1, 0, 1 ..) together reach 0: theorem 7 asks
 * for no more than is needed. */
static void value_bounds_are_tight(void **unused)
{
    (void)unused;
    static fixture f;
    for (uint32_t labels = 3; labels <= 5; labels += 2) {
        make_grid(&f, 2, 2, labels, 10, QS_POTTS);
        for (uint32_t i = 0; i < labels * labels; i++) {
            f.t.table[i] = (i / labels + i % labels) % 2;
        }
        for (uint32_t i = 0; i < 4 * labels; i++) {
            f.t.costs[i] = i % labels % 2 == 1 ? 25 : 0;
        }
        f.t.problem.pairwise = (qs_pairwise){QS_TABLE, 0, f.t.table};
        assert_walls_are_tight(&f);
    }
}

/* Costs (0, t, 0) of two sites with quadratic costs: kappa = 2 t - 2 W + gap, and where that would
 * be less, the gap alone. */
static void square_values(void **unused)
{
    (void)unused;
    static fixture f;
    static const int32_t inner[] = {25, 10, 3}, kappa[] = {2 * 25 - 2 * 10 + 2, 2, 2};
    for (int i = 0; i < 3; i++) {
        make_grid(&f, 2, 1, 3, 10, QS_TRUNCATED_QUADRATIC);
        for (uint32_t at = 0; at < 6; at++) {
            f.t.costs[at] = at % 3 == 1 ? inner[i] : 0;
        }
        make_model(&f);
        assert_int_equal(
            recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL, .gap = 2}, false), QS_OK);
        assert_int_equal(qs_qubo_linear(&f.qubo, 1), kappa[i] - inner[i] + 30);
        check_states(&f, 2, false);
    }
}

static int64_t pairs_at_one(const fixture *f, uint64_t state)
{
    int64_t pairs = 0;
    uint32_t at = 0;
    for (uint32_t p = 0; p < f->sites; p++) {
        uint32_t n = count_labels(f, p);
        int64_t s = 0;
        for (uint64_t bits = cut_out(state, &at, n); bits != 0; bits &= bits - 1) {
            s++;
        }
        pairs += s * (s - 1) / 2;
    }
    return pairs;
}

/* Half units are rounded up: W = 5, T = 3. */
static void minimal_values(void **unused)
{
    (void)unused;
    static fixture f;
    static const qs_encode_options options = {QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL, 0, 4};
    int64_t a, b;
    make_grid(&f, 2, 1, 5, 5, QS_POTTS);
    assert_int_equal(recode(&f, options, false), QS_OK);
    qs_index_penalty(&f.index, 0, &a, &b);
    assert_int_equal(a, 4);
    assert_int_equal(b, a + 3 + 4);
    make_grid(&f, 2, 1, 5, 5, QS_TRUNCATED_LINEAR);
    f.t.problem.pairwise.truncation = 3;
    make_model(&f);
    assert_int_equal(recode(&f, options, false), QS_OK);
    qs_index_penalty(&f.index, 0, &a, &b);
    assert_int_equal(a, 4);
    assert_int_equal(b, a + (15 * 5 + 3) / 4 + 4);
}

/* A star K(1,4): the centre is free in two labels, two leaves are bound to each (and a 2 x 3 grid
 * whose inner sites are so): the sites with two labels cost as much as they save. */
static void sparse_bounds_are_tight(void **unused)
{
    (void)unused;
    static fixture f;
    memset(&f, 0, sizeof f);
    for (uint32_t leaf = 0; leaf < 4; leaf++) {
        f.t.edges[leaf] = (qs_edge){0, leaf + 1, 100};
        f.t.costs[2 + 2 * leaf + (leaf < 2)] = 10000;
    }
    f.t.problem = (qs_problem){.sites = 5,
                               .labels = 2,
                               .scale = 1,
                               .edges = f.t.edges,
                               .edge_count = 4,
                               .costs = f.t.costs};
    make_model(&f);
    for (uint32_t gap = 1; gap <= 6; gap += 5) {
        assert_int_equal(recode(&f,
                                (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE,
                                                    .penalty = QS_PENALTY_MINIMAL,
                                                    .gap = gap},
                                false),
                         QS_OK);
        assert_int_equal(margin(&f, 0, pairs_at_one), gap);
        assert_int_equal(margin(&f, 1, pairs_at_one), gap - 1);
    }
    /* 2 x 3: the corners are bound, those of the left column to 0, of the right one to 1. */
    make_grid(&f, 3, 2, 2, 100, QS_POTTS);
    for (uint32_t p = 0; p < 6; p++) {
        f.t.costs[2 * p] = p % 3 == 2 ? 10000 : 0;
        f.t.costs[2 * p + 1] = p % 3 == 0 ? 10000 : 0;
    }
    make_model(&f);
    assert_int_equal(recode(&f,
                            (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE,
                                                .penalty = QS_PENALTY_MINIMAL,
                                                .gap = 1},
                            false),
                     QS_OK);
    assert_int_equal(margin(&f, 1, pairs_at_one), 0);
    assert_true(margin(&f, 2, pairs_at_one) < 0);
}

static int64_t empty_sites(const fixture *f, uint64_t state)
{
    int64_t empty = 0;
    uint32_t at = 0;
    for (uint32_t p = 0; p < f->sites; p++) {
        empty += cut_out(state, &at, count_labels(f, p)) == 0;
    }
    return empty;
}

/* The same star, the centre bound to one label and the leaves to the other: an empty centre costs
 * a, a labelling W = 400. A third label that is gone changes nothing, and leaves that are fixed are
 * no concern of the centre's penalty. */
static void one_hot_bound_is_tight(void **unused)
{
    (void)unused;
    static fixture f;
    memset(&f, 0, sizeof f);
    for (uint32_t leaf = 0; leaf < 4; leaf++) {
        f.t.edges[leaf] = (qs_edge){0, leaf + 1, 100};
    }
    for (uint32_t p = 0; p < 5; p++) {
        f.t.costs[3 * p + (p == 0)] = 10000;
    }
    f.t.problem = (qs_problem){.sites = 5,
                               .labels = 3,
                               .scale = 1,
                               .edges = f.t.edges,
                               .edge_count = 4,
                               .costs = f.t.costs};
    make_model(&f);
    for (uint32_t fixed = 0; fixed <= 4; fixed++) {
        int64_t a, b;
        for (uint32_t p = 0; p < 5; p++) {
            f.left[p] = p > 0 && p <= fixed ? 2 : 3;
        }
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ONE_HOT, .gap = 7}, false),
                         QS_OK);
        qs_index_penalty(&f.index, 0, &a, &b);
        assert_int_equal(a, 100 * (4 - fixed) + 7);
        assert_int_equal(b, a + 7);
        if (fixed == 0) {
            assert_int_equal(margin(&f, 0, empty_sites), 7);
            assert_int_equal(margin(&f, 1, empty_sites), 6);
        }
    }
}

/* ---- The paper's example: 3 x 3, two labels. ---- */

static void set_bit(uint8_t *bits, uint32_t at)
{
    bits[at / 8] |= (uint8_t)(1u << at % 8);
}

/* The state of a labelling where every site has all labels, arcs' variables at their best. */
static void encode_labelling(const fixture *f, const uint16_t *labelling, uint8_t *bits)
{
    qs_encoding encoding = f->qubo.labels.encoding;
    uint32_t labels = f->t.problem.labels, at = 0;
    memset(bits, 0, BYTES);
    for (uint32_t p = 0; p < f->sites; p++) {
        uint32_t size = encoding == QS_DOMAIN_WALL ? labels - 1
                        : encoding >= QS_ST_CUT    ? labels + 1
                                                   : labels;
        for (uint32_t i = 0; i < size; i++) {
            bool one = encoding == QS_DOMAIN_WALL ? i < labelling[p]
                       : encoding >= QS_ST_CUT    ? i <= labelling[p]
                                                  : i == labelling[p];
            if (one) {
                set_bit(bits, at + i);
            }
        }
        at += size;
    }
    for (uint32_t t = 0; encoding == QS_MULTIWAY_CUT && t < labels; t++) {
        set_bit(bits, at + t * labels + t);
    }
    if (encoding >= QS_ST_CUT) {
        set_bit(bits, at);
    }
    for (uint32_t z = at + 2; encoding == QS_ST_CUT_ARCS && z < f->qubo.variables; z++) {
        int64_t before = qs_qubo_energy(&f->index, bits);
        set_bit(bits, z);
        if (qs_qubo_energy(&f->index, bits) > before) {
            bits[z / 8] &= (uint8_t)~(1u << z % 8);
        }
    }
}

static void papers_example(void **unused)
{
    (void)unused;
    static fixture f;
    static const uint32_t fifty[6] = {0, 3, 8, 11, 12, 15};
    static const uint64_t variables[7] = {0, 18, 18, 9, 22, 29, 29 + 2 * 72};
    make_grid(&f, 3, 3, 2, 10, QS_POTTS);
    memset(f.t.costs, 0, sizeof f.t.costs);
    for (int i = 0; i < 6; i++) {
        f.t.costs[fifty[i]] = 50;
    }
    make_model(&f);
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        int optima = 0;
        uint64_t state = 16;
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = encoding}, false), QS_OK);
        assert_int_equal(f.qubo.variables, variables[encoding]);
        assert_true(encoding != QS_DOMAIN_WALL || f.qubo.couplings == 12);
        for (uint32_t n = 0; n < 1u << 9; n++) {
            uint16_t labelling[9];
            uint8_t bits[BYTES];
            for (uint32_t p = 0; p < 9; p++) {
                labelling[p] = n >> p & 1;
            }
            encode_labelling(&f, labelling, bits);
            int64_t h = qs_qubo_energy(&f.index, bits);
            assert_int_equal(h, problem_energy(&f, labelling));
            assert_true(h >= 50);
            optima += h == 50;
        }
        assert_int_equal(optima, 1);
        for (int draw = 0; draw < 20000; draw++) {
            uint8_t bits[BYTES] = {0};
            for (uint32_t i = 0; i < f.qubo.variables; i++) {
                bits[i / 8] |= (uint8_t)(tiny_random(&state, 2) << i % 8);
            }
            assert_true(qs_qubo_energy(&f.index, bits) >= 50);
        }
    }
}

/* ---- Bytes. ---- */

/* Where nothing has left, the bytes are those of qs_encode. */
static void whole_problems_are_those_of_encode(void **unused)
{
    (void)unused;
    static fixture f;
    static uint8_t direct[MEMORY];
    static uint64_t memory[MEMORY / 8];
    uint64_t state = 17;
    uint32_t lone = 0;
    for (int round = 0; round < ROUNDS; round++) {
        memset(&f, 0, sizeof f);
        tiny_make(&f.t, &state, SOURCE_BITS, round % 2 == 0);
        for (uint32_t i = 0; i < TINY_SITES * TINY_LABELS; i++) {
            f.t.costs[i] += 10; /* none is negative: the file of a model says no more than the sum
                                   of the least ones */
        }
        qs_encode_options options = {QS_ONE_HOT, (qs_penalty)tiny_random(&state, 4), 12345,
                                     1 + tiny_random(&state, 4)};
        bool linear_cost = f.t.problem.pairwise.smoothness == QS_TRUNCATED_LINEAR;
        if (tiny_random(&state, 2) == 0 && (f.t.problem.pairwise.smoothness == QS_POTTS ||
                                            (linear_cost && options.penalty != QS_PENALTY_PAPER))) {
            options.encoding = QS_ONE_HOT_SPARSE;
        }
        make_model(&f);
        lone += f.t.problem.pairwise.smoothness == QS_TABLE && f.source_qubo.couplings == 0;
        assert_int_equal(recode(&f, options, false), QS_OK);
        qs_buffer buffer = {direct, sizeof direct, 0};
        qs_sink sink = qs_buffer_sink(&buffer);
        assert_int_equal(qs_encode(&f.t.problem, &options, &sink, memory, sizeof memory, NULL),
                         QS_OK);
        assert_int_equal(f.size, buffer.size);
        assert_memory_equal(f.file, direct, f.size);
    }
    assert_true(lone > 0); /* tables that couple nothing */
}

/* Masked cells end a run, and so does the last edge to the right. */
static void masked_rows_are_runs_of_their_own(void **unused)
{
    (void)unused;
    static fixture f;
    static uint8_t direct[MEMORY];
    static uint64_t memory[MEMORY / 8];
    for (uint32_t mask = 1; mask < 1 << 6; mask++) {
        for (uint32_t width = 1; width <= 6; width++) {
            if (6 % width > 0) {
                continue;
            }
            make_grid(&f, width, 6 / width, 2, 5, QS_POTTS);
            for (uint32_t c = 0; c < 6; c++) {
                f.t.mask[c] = mask >> c & 1;
            }
            f.t.problem.grid.mask = f.t.mask;
            make_model(&f);
            qs_encode_options options = {.encoding = QS_ONE_HOT};
            assert_int_equal(recode(&f, options, false), QS_OK);
            qs_buffer buffer = {direct, sizeof direct, 0};
            qs_sink sink = qs_buffer_sink(&buffer);
            assert_int_equal(qs_encode(&f.t.problem, &options, &sink, memory, sizeof memory, NULL),
                             QS_OK);
            assert_int_equal(f.size, buffer.size);
            assert_memory_equal(f.file, direct, f.size);
        }
    }
}

/* Neither label sets nor truncation are noted where there are none. */
static void nothing_left_to_decide(void **unused)
{
    (void)unused;
    static fixture f;
    make_grid(&f, 3, 2, 3, 5, QS_TRUNCATED_LINEAR);
    uint16_t labelling[6] = {0, 1, 2, 2, 1, 0};
    for (uint32_t p = 0; p < 6; p++) {
        f.left[p] = (uint64_t)1 << labelling[p];
    }
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        if (encoding == QS_MULTIWAY_CUT) {
            continue;
        }
        uint8_t none = 0;
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = encoding}, true), QS_OK);
        assert_int_equal(f.qubo.variables, 0);
        assert_int_equal(f.qubo.groups, 0);
        assert_int_equal(f.qubo.labels.undecided, 0);
        assert_int_equal(qs_qubo_energy(&f.index, &none), problem_energy(&f, labelling));
    }
}

/* Labels that need two bytes in the file's chunk: 300 of them. */
static void labels_beyond_a_byte(void **unused)
{
    (void)unused;
    enum { MANY = 300, SITES = 3, VARIABLES = 3 + MANY };
    static fixture f;
    static int32_t costs[SITES * MANY];
    static uint8_t kept[SITES * MANY];
    static const uint32_t three[3] = {0, 150, 299};
    memset(&f, 0, sizeof f);
    for (uint32_t i = 0; i < SITES * MANY; i++) {
        costs[i] = (int32_t)(i % 17);
        kept[i] = i >= 2 * MANY;
    }
    f.t.edges[0] = (qs_edge){0, 1, 3};
    f.t.edges[1] = (qs_edge){1, 2, 4};
    f.t.problem = (qs_problem){.sites = SITES,
                               .labels = MANY,
                               .scale = 1,
                               .edges = f.t.edges,
                               .edge_count = 2,
                               .costs = costs};
    make_model(&f);
    kept[299] = 1; /* of site 0 that label alone */
    for (int i = 0; i < 3; i++) {
        kept[MANY + three[i]] = 1;
    }
    static uint64_t memory[MEMORY / 8];
    qs_recode_options options = {.encode.encoding = QS_ONE_HOT_SPARSE, .kept = kept};
    qs_buffer buffer = {f.file, sizeof f.file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_int_equal(
        qs_recode(&f.model, &f.source_qubo.labels, &options, &sink, memory, sizeof memory, NULL),
        QS_OK);
    open_file(f.file, buffer.size, &f.qubo, f.memory, &f.index);
    assert_int_equal(f.qubo.variables, VARIABLES);
    assert_int_equal(f.qubo.labels.fixed_bytes, 2);
    assert_int_equal(f.qubo.labels.fixed[0] | f.qubo.labels.fixed[1] << 8, 299);
    for (uint32_t i = 0; i < 3; i++) {
        for (uint32_t d = 0; d < MANY; d++) {
            uint16_t labelling[SITES] = {299, (uint16_t)three[i], (uint16_t)d};
            uint8_t bits[BYTES] = {0};
            set_bit(bits, i);
            set_bit(bits, 3 + d);
            assert_int_equal(qs_qubo_energy(&f.index, bits), problem_energy(&f, labelling));
        }
    }
}

/* What fixed neighbours add to a cost may be too much for a model; then no encoding that a model is
 * built from is written. */
static void costs_beyond_a_model(void **unused)
{
    (void)unused;
    static fixture f;
    static uint64_t memory[MEMORY / 8];
    qs_model model;
    const qs_encoding encodings[] = {QS_ONE_HOT,      QS_ONE_HOT_SPARSE, QS_DOMAIN_WALL,
                                     QS_MULTIWAY_CUT, QS_ST_CUT,         QS_ST_CUT_ARCS};
    for (int round = 0; round < 4 * 6; round++) {
        bool over = round % 2 == 1, truncate = round / 2 % 2 == 1;
        qs_encoding encoding = encodings[round / 4];
        make_grid(&f, 2, 1, 2, 5, QS_POTTS);
        memset(f.t.costs, 0, sizeof f.t.costs);
        f.t.costs[3] = INT32_MAX - 5 + over; /* of site 1, label 1: and 5 more beside label 0 */
        make_model(&f);
        f.left[0] = 1;
        qs_status status = recode(&f, (qs_encode_options){.encoding = encoding}, truncate);
        bool modelled = encoding <= QS_DOMAIN_WALL;
        if (modelled || truncate) { /* else a cut's capacities may be too large */
            assert_int_equal(status, over && modelled ? QS_E_OVERFLOW : QS_OK);
        }
        if (modelled && !over) {
            assert_int_equal(qs_model_build(&f.index, memory, sizeof memory, &model), QS_OK);
            assert_int_equal(model.unary[3], INT32_MAX);
        }
    }
}

static void refusals(void **unused)
{
    (void)unused;
    static fixture f;
    static const qs_penalty fixed[2] = {QS_PENALTY_PAPER, QS_PENALTY_GIVEN};
    make_grid(&f, 2, 2, 3, 5, QS_POTTS);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(recode(&f, (qs_encode_options){QS_DOMAIN_WALL, fixed[i], 9, 0}, false),
                         QS_E_ENCODING);
        assert_int_equal(recode(&f, (qs_encode_options){QS_MULTIWAY_CUT, fixed[i], 9, 0}, false),
                         QS_OK);
    }
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ST_CUT}, false), QS_E_ENCODING);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ST_CUT_ARCS + 1}, false),
                     QS_E_ARGUMENT);
    assert_int_equal(recode(&f, (qs_encode_options){.penalty = QS_PENALTY_MINIMAL + 1}, false),
                     QS_E_ARGUMENT);
    assert_int_equal(recode(&f, (qs_encode_options){.penalty = QS_PENALTY_GIVEN}, false),
                     QS_E_ARGUMENT);
    assert_int_equal(
        recode(&f, (qs_encode_options){.penalty = QS_PENALTY_GIVEN, .alpha = INT64_MAX}, false),
        QS_E_OVERFLOW);
    assert_int_equal(
        recode(&f, (qs_encode_options){.penalty = QS_PENALTY_GIVEN, .alpha = (int64_t)1 << 50},
               false),
        QS_E_OVERFLOW);
    /* M = 4 sites x (4 a + 3 b) and some more, b = 2 a. */
    assert_int_equal(
        recode(&f, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_GIVEN, QS_ENERGY_MAX / 40, 0}, false),
        QS_E_OVERFLOW);
    assert_int_equal(
        recode(&f, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_GIVEN, QS_ENERGY_MAX / 41, 0}, false),
        QS_OK);
    /* kappa is a weight of 32 bits. */
    assert_int_equal(
        recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL, .gap = INT32_MAX}, false),
        QS_E_OVERFLOW);
    f.left[3] = 0;
    assert_int_equal(recode(&f, (qs_encode_options){0}, false), QS_E_ARGUMENT);
    make_grid(&f, 2, 2, 3, 5, QS_TRUNCATED_LINEAR);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_MULTIWAY_CUT}, false),
                     QS_E_ENCODING);
    assert_int_equal(recode(&f, (qs_encode_options){QS_ST_CUT, QS_PENALTY_PAPER, 0, 0}, false),
                     QS_E_ENCODING);
    assert_int_equal(
        recode(&f, (qs_encode_options){QS_ONE_HOT_SPARSE, QS_PENALTY_PAPER, 0, 0}, false),
        QS_E_ENCODING);
    f.t.problem.pairwise.truncation = 1;
    make_model(&f);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ST_CUT_ARCS}, false),
                     QS_E_ENCODING);
    make_grid(&f, 2, 2, 3, 5, QS_TRUNCATED_QUADRATIC);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE}, false),
                     QS_E_ENCODING);
}

static bool key_before(const void *context, uint32_t a, uint32_t b)
{
    const uint32_t *keys = context;
    return keys[a] < keys[b];
}

static void equals_keep_their_order(void **unused)
{
    (void)unused;
    uint64_t state = 18;
    for (uint32_t count = 0; count < 70; count++) {
        uint32_t keys[70], items[70], scratch[70];
        for (uint32_t i = 0; i < count; i++) {
            keys[i] = tiny_random(&state, 9);
            items[i] = i;
        }
        qs_sort(items, scratch, count, key_before, keys);
        for (uint32_t i = 1; i < count; i++) {
            uint32_t before = keys[items[i - 1]], here = keys[items[i]];
            assert_true(before < here || (before == here && items[i - 1] < items[i]));
        }
    }
}

/* A sink that takes `left` more calls. */
static bool failing_write(void *context, const void *bytes, size_t size)
{
    (void)bytes;
    (void)size;
    return (*(int *)context)-- > 0;
}

static void every_failing_write_is_told(void **unused)
{
    (void)unused;
    static fixture f;
    static uint64_t memory[MEMORY / 8];
    make_grid(&f, 4, 3, 3, 5, QS_POTTS);
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_MULTIWAY_CUT; encoding++) {
        int calls = 0;
        for (qs_status status = QS_E_IO; status != QS_OK; calls++) {
            int left = calls;
            qs_sink sink = {failing_write, &left};
            status = qs_recode(&f.model, &f.source_qubo.labels,
                               &(qs_recode_options){.encode.encoding = encoding}, &sink, memory,
                               sizeof memory, NULL);
            assert_true(status == QS_E_IO || status == QS_OK);
            assert_true(calls < 1000);
        }
        assert_true(calls > 7);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masked_rows_are_runs_of_their_own),
        cmocka_unit_test(counts_by_formula),
        cmocka_unit_test(wall_bounds_are_tight),
        cmocka_unit_test(value_bounds_are_tight),
        cmocka_unit_test(square_values),
        cmocka_unit_test(minimal_values),
        cmocka_unit_test(sparse_bounds_are_tight),
        cmocka_unit_test(one_hot_bound_is_tight),
        cmocka_unit_test(papers_example),
        cmocka_unit_test(whole_problems_are_those_of_encode),
        cmocka_unit_test(nothing_left_to_decide),
        cmocka_unit_test(labels_beyond_a_byte),
        cmocka_unit_test(costs_beyond_a_model),
        cmocka_unit_test(refusals),
        cmocka_unit_test(equals_keep_their_order),
        cmocka_unit_test(every_failing_write_is_told),
    };
    return cmocka_run_group_tests_name("recode bounds", tests, NULL, NULL);
}
