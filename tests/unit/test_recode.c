/* Every encoding, over all labels and over those that are left, against all states of tiny problems (docs/MATHS.md). */
#include "tiny.h"

#include <stdlib.h>
#include <string.h>

#include "../../libqstereo/src/sort.h"

enum { ROUNDS = 500, BITS = 12, SOURCE_BITS = 24, MEMORY = 1 << 16, BYTES = 64 };

/* A problem, its model, the labels left, and a file of it. */
typedef struct fixture {
    tiny t;
    uint32_t sites;
    uint32_t cell[TINY_SITES]; /* of each site the model's */
    uint64_t left[TINY_SITES]; /* bit d = label d is left */
    uint8_t kept[TINY_SITES * TINY_LABELS];
    uint8_t source[MEMORY], file[MEMORY];
    uint64_t source_memory[MEMORY / 8], model_memory[MEMORY / 8], memory[MEMORY / 8];
    size_t source_size, size;
    qs_qubo source_qubo, qubo;
    qs_index source_index, index;
    qs_model model;
} fixture;

/* ---- Making files. ---- */

static void open_file(const uint8_t *file, size_t size, qs_qubo *qubo, uint64_t *memory, qs_index *index)
{
    assert_int_equal(qs_qubo_open(file, size, MEMORY, qubo, NULL), QS_OK);
    assert_int_equal(qs_index_build(qubo, memory, MEMORY, index), QS_OK);
}

/* The model of f->t.problem, by way of the file that qs_encode makes; all labels are left. */
static void make_model(fixture *f)
{
    const qs_problem *p = &f->t.problem;
    static uint64_t memory[MEMORY / 8];
    qs_buffer buffer = {f->source, sizeof f->source, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_int_equal(qs_encode(p, &(qs_encode_options){.encoding = QS_ONE_HOT}, &sink, memory, sizeof memory, NULL), QS_OK);
    f->source_size = buffer.size;
    open_file(f->source, f->source_size, &f->source_qubo, f->source_memory, &f->source_index);
    assert_int_equal(qs_model_build(&f->source_index, f->model_memory, sizeof f->model_memory, &f->model), QS_OK);
    f->sites = 0;
    for (uint32_t c = 0; c < f->model.sites; c++) {
        bool masked = p->grid.width > 0 && p->grid.mask && p->grid.mask[c] == 0;
        if (!masked) {
            f->left[f->sites] = p->labels < 64 ? ((uint64_t)1 << p->labels) - 1 : UINT64_MAX;
            f->cell[f->sites++] = c;
        }
    }
}

/* Each label leaves with one of several chances; every site keeps one. */
static void draw_labels(fixture *f, uint64_t *state)
{
    uint32_t labels = f->t.problem.labels, chance = tiny_random(state, 4);
    for (uint32_t p = 0; p < f->sites; p++) {
        for (uint32_t d = 0; d < labels; d++) {
            if (tiny_random(state, 4) < chance) {
                f->left[p] &= ~((uint64_t)1 << d);
            }
        }
        f->left[p] |= (uint64_t)(f->left[p] == 0) << tiny_random(state, labels);
    }
}

static bool has(const fixture *f, uint32_t site, uint32_t label)
{
    return (f->left[site] >> label & 1) != 0;
}

static qs_status recode(fixture *f, qs_encode_options options, bool truncate)
{
    uint32_t labels = f->t.problem.labels;
    bool all = true;
    memset(f->kept, 0, sizeof f->kept);
    for (uint32_t p = 0; p < f->sites; p++) {
        for (uint32_t d = 0; d < labels; d++) {
            f->kept[f->cell[p] * labels + d] = has(f, p, d);
            all &= has(f, p, d);
        }
    }
    qs_recode_options recode_options = {options, truncate, all ? NULL : f->kept};
    size_t size = qs_recode_workspace(&f->model, &recode_options);
    void *workspace = malloc(size + !size); /* of that very size: the sanitizer sees a byte too many */
    qs_buffer buffer = {f->file, sizeof f->file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    uint64_t told = 0, counted = 0;
    qs_status status = qs_recode(&f->model, &f->source_qubo, &recode_options, &sink, workspace, size, &told);
    if (status == QS_OK) {
        assert_int_equal(qs_recode(&f->model, &f->source_qubo, &recode_options, NULL, workspace, size, &counted), QS_OK);
        assert_int_equal(told, buffer.size);
        assert_int_equal(counted, told);
        if (size > 0) {
            assert_int_equal(qs_recode(&f->model, &f->source_qubo, &recode_options, NULL, workspace, size - 1, NULL), QS_E_WORKSPACE);
        }
        f->size = buffer.size;
        open_file(f->file, f->size, &f->qubo, f->memory, &f->index);
    }
    free(workspace);
    return status;
}

/* ---- Meaning, from docs/FORMAT.md's table. ---- */

static uint32_t count_labels(const fixture *f, uint32_t site)
{
    uint32_t count = 0;
    for (uint32_t d = 0; d < f->t.problem.labels; d++) {
        count += has(f, site, d);
    }
    return count;
}

static uint32_t nth_label(const fixture *f, uint32_t site, uint32_t n)
{
    for (uint32_t d = 0;; d++) {
        if (has(f, site, d) && n-- == 0) {
            return d;
        }
    }
}

static bool is_open(const fixture *f, uint32_t site)
{
    bool plain = f->t.problem.labels == 1 && f->qubo.labels.encoding <= QS_ONE_HOT_SPARSE;
    return plain || count_labels(f, site) > 1;
}

/* The number of the only 1 among `count` bits; `count` = it is not so. */
static uint32_t only_one(uint64_t bits, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (bits == (uint64_t)1 << i) {
            return i;
        }
    }
    return count;
}

/* The number of ones where all of them stand first; UINT32_MAX = it is not so. */
static uint32_t leading_ones(uint64_t bits, uint32_t count)
{
    for (uint32_t ones = 0; ones <= count; ones++) {
        if (bits == ((uint64_t)1 << ones) - 1) {
            return ones;
        }
    }
    return UINT32_MAX;
}

static uint64_t cut_out(uint64_t state, uint32_t *at, uint32_t count)
{
    uint64_t bits = state >> *at & (((uint64_t)1 << count) - 1);
    *at += count;
    return bits;
}

/* The labelling that a state of at most 63 variables stands for, without those of arcs; false if none. `extra` = what truncation has taken from its costs. */
static bool decode(const fixture *f, uint64_t state, uint16_t *labelling, int64_t *extra)
{
    qs_encoding encoding = f->qubo.labels.encoding;
    uint32_t at = 0, excess = 0, open = 0, labels = f->t.problem.labels;
    const qs_labels *l = &f->qubo.labels;
    *extra = 0;
    for (uint32_t p = 0; p < f->sites; p++) {
        uint32_t n = count_labels(f, p), index;
        if (!is_open(f, p)) {
            labelling[p] = (uint16_t)nth_label(f, p, 0);
            continue;
        }
        if (encoding == QS_DOMAIN_WALL) {
            index = leading_ones(cut_out(state, &at, n - 1), n - 1);
        } else if (encoding >= QS_ST_CUT) {
            index = leading_ones(cut_out(state, &at, n + 1), n) - 1; /* of none at all: UINT32_MAX - 1 or - 2 */
        } else {
            index = only_one(cut_out(state, &at, n), n);
        }
        if (index >= n) {
            return false;
        }
        labelling[p] = (uint16_t)nth_label(f, p, index);
        for (unsigned b = 0; b < l->excess_bytes; b++) {
            *extra += (int64_t)l->excess[(excess + index) * l->excess_bytes + b] << 8 * b;
        }
        excess += n;
        open++;
    }
    for (uint32_t t = 0; encoding == QS_MULTIWAY_CUT && open > 0 && t < labels; t++) {
        if (only_one(cut_out(state, &at, labels), labels) != t) {
            return false;
        }
    }
    return encoding < QS_ST_CUT || open == 0 || cut_out(state, &at, 2) == 1;
}

static void to_bytes(uint64_t state, uint8_t bits[BYTES])
{
    memset(bits, 0, BYTES);
    for (int i = 0; i < 8; i++) {
        bits[i] = (uint8_t)(state >> 8 * i);
    }
}

static int64_t energy_of(const fixture *f, uint64_t state)
{
    uint8_t bits[BYTES];
    to_bytes(state, bits);
    return qs_qubo_energy(&f->index, bits);
}

static int64_t problem_energy(const fixture *f, const uint16_t *labelling)
{
    int64_t energy;
    assert_int_equal(qs_problem_energy(&f->t.problem, labelling, NULL, 0, &energy), QS_OK);
    return energy;
}

/* The least F over the labellings of the labels left, and how many such labellings there are. */
static int64_t least_energy(const fixture *f, uint64_t *labellings)
{
    uint16_t labelling[TINY_SITES];
    int64_t least = INT64_MAX;
    *labellings = 1;
    for (uint32_t p = 0; p < f->sites; p++) {
        *labellings *= count_labels(f, p);
    }
    for (uint64_t n = 0; n < *labellings; n++) {
        uint64_t rest = n;
        for (uint32_t p = 0; p < f->sites; p++) {
            labelling[p] = (uint16_t)nth_label(f, p, (uint32_t)(rest % count_labels(f, p)));
            rest /= count_labels(f, p);
        }
        int64_t energy = problem_energy(f, labelling);
        least = energy < least ? energy : least;
    }
    return least;
}

/* ---- What the file says of itself. ---- */

/* The chunk kept, from the bytes. */
static void check_kept(const fixture *f, bool all)
{
    const qs_labels *l = &f->qubo.labels;
    uint32_t labels = f->t.problem.labels, open = 0;
    assert_int_equal(l->sites, f->sites);
    if (all && (labels > 1 || l->encoding <= QS_ONE_HOT_SPARSE)) {
        assert_int_equal(l->fixed_bytes, 0);
        return;
    }
    assert_int_equal(l->fixed_bytes, 1);
    for (uint32_t p = 0; p < f->sites; p++) {
        if (count_labels(f, p) == 1) {
            assert_int_equal(l->fixed[p], nth_label(f, p, 0));
        } else {
            assert_int_equal(l->fixed[p], UINT8_MAX);
            assert_int_equal(l->sets[open++], f->left[p]);
        }
    }
    assert_int_equal(l->open, open);
}

static void check_file(const fixture *f)
{
    uint32_t labels = f->t.problem.labels;
    bool all = true;
    for (uint32_t p = 0; p < f->sites; p++) {
        all &= count_labels(f, p) == labels;
    }
    check_kept(f, all);
    assert_int_equal(f->qubo.labels.weight, f->source_qubo.labels.weight);
    for (uint32_t g = 0; !all && g < f->qubo.groups; g++) {
        for (uint32_t n = f->index.near_start[g]; n < f->index.near_start[g + 1]; n++) {
            assert_int_not_equal(f->index.near[n].weight, 0);
        }
    }
}

/* ---- All states. ---- */

typedef struct sweep {
    int64_t least;   /* H of any labelling, */
    int64_t extra;   /* and the most that truncation has taken from one of that H: those are to be the optima */
    int64_t invalid; /* H of any other state */
    uint64_t labellings;
    uint32_t stuck; /* other states that no flip lowers by the gap */
} sweep;

static sweep sweep_states(const fixture *f, int64_t gap)
{
    static int64_t energy[1 << 16];
    sweep s = {INT64_MAX, 0, INT64_MAX, 0, 0};
    uint32_t variables = f->qubo.variables;
    for (uint64_t state = 0; state < (uint64_t)1 << variables; state++) {
        energy[state] = energy_of(f, state);
    }
    for (uint64_t state = 0; state < (uint64_t)1 << variables; state++) {
        uint16_t labelling[TINY_SITES];
        int64_t extra, h = energy[state];
        if (decode(f, state, labelling, &extra)) {
            assert_int_equal(h + extra, problem_energy(f, labelling));
            s.labellings++;
            s.extra = h < s.least || (h == s.least && extra > s.extra) ? extra : s.extra;
            s.least = h < s.least ? h : s.least;
            continue;
        }
        s.invalid = h < s.invalid ? h : s.invalid;
        bool improves = false;
        for (uint32_t i = 0; i < variables && !improves; i++) {
            improves = energy[state ^ (uint64_t)1 << i] <= h - gap;
        }
        s.stuck += !improves;
    }
    return s;
}

/* Some of the states, far apart, with the library's own repair: F of a labelling, lower by the gap where the state is none. */
static void check_repair(const fixture *f, int64_t gap)
{
    enum { TRIED = 48 };
    const uint64_t step = 2654435761u; /* odd: all low bits change */
    static uint64_t memory[MEMORY / 8];
    for (uint64_t i = 0, state = 0; i < TRIED && f->qubo.variables > 0; i++, state += step) {
        uint64_t tried = state & (((uint64_t)1 << f->qubo.variables) - 1), mended = 0;
        uint16_t labelling[TINY_SITES];
        uint8_t bits[BYTES];
        int64_t extra;
        bool good = decode(f, tried, labelling, &extra);
        to_bytes(tried, bits);
        assert_true(qs_repair_workspace(&f->index) <= sizeof memory);
        assert_int_equal(qs_sample_repair(&f->index, bits, memory, sizeof memory, NULL), QS_OK);
        for (int b = 0; b < 8; b++) {
            mended |= (uint64_t)bits[b] << 8 * b;
        }
        assert_true(decode(f, mended, labelling, &extra));
        assert_true(energy_of(f, mended) <= energy_of(f, tried) - (good ? 0 : gap));
    }
}

static void check_states(const fixture *f, int64_t gap, bool flips)
{
    check_repair(f, gap);
    uint64_t labellings;
    int64_t least = least_energy(f, &labellings);
    sweep s = sweep_states(f, gap);
    assert_int_equal(s.least, least);
    assert_int_equal(s.extra, 0);
    assert_int_equal(s.labellings, labellings);
    assert_true(s.invalid == INT64_MAX || s.invalid >= least + gap);
    assert_true(!flips || s.stuck == 0);
}

/* ---- Random problems. ---- */

static void any_smoothness(fixture *f, uint64_t *state)
{
    (void)f;
    (void)state;
}

static void potts(fixture *f, uint64_t *state)
{
    (void)state;
    f->t.problem.pairwise.smoothness = QS_POTTS;
}

static void linear(fixture *f, uint64_t *state)
{
    f->t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_LINEAR, tiny_random(state, 5), NULL};
}

static void whole_linear(fixture *f, uint64_t *state)
{
    uint32_t labels = f->t.problem.labels;
    f->t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_LINEAR, tiny_random(state, 2) ? 0 : labels - 1 + tiny_random(state, 2), NULL};
}

/* A random file of at most `bits` variables; false = it has more. */
static bool random_file(fixture *f, uint64_t *state, uint32_t bits, void (*smoothness)(fixture *, uint64_t *), qs_encode_options options)
{
    memset(f, 0, sizeof *f);
    tiny_make(&f->t, state, SOURCE_BITS, false);
    smoothness(f, state);
    make_model(f);
    draw_labels(f, state);
    if (tiny_random(state, 4) == 0) {
        make_model(f); /* all labels again */
    }
    assert_int_equal(recode(f, options, tiny_random(state, 3) == 0), QS_OK);
    check_file(f);
    return f->qubo.variables <= bits;
}

static void many(uint64_t seed, uint32_t bits, void (*smoothness)(fixture *, uint64_t *), qs_encoding encoding, qs_penalty penalty, bool flips)
{
    static fixture f;
    uint64_t state = seed;
    for (int round = 0; round < ROUNDS;) {
        uint32_t gap = penalty == QS_PENALTY_LOCAL || penalty == QS_PENALTY_MINIMAL ? 1 + tiny_random(&state, 3) : 1;
        if (random_file(&f, &state, bits, smoothness, (qs_encode_options){encoding, penalty, 0, gap})) {
            assert_int_equal(f.qubo.labels.encoding, encoding);
            assert_int_equal(f.qubo.labels.penalty, penalty);
            assert_int_equal(f.qubo.labels.gap, gap);
            check_states(&f, gap, flips);
            round++;
        }
    }
}

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
    } kinds[] = {{any_smoothness, QS_ONE_HOT, QS_PENALTY_LOCAL}, {linear, QS_ONE_HOT_SPARSE, QS_PENALTY_LOCAL},
                 {linear, QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL}, {potts, QS_ONE_HOT_SPARSE, QS_PENALTY_MINIMAL},
                 {potts, QS_DOMAIN_WALL, QS_PENALTY_LOCAL}, {linear, QS_DOMAIN_WALL, QS_PENALTY_LOCAL},
                 {whole_linear, QS_DOMAIN_WALL, QS_PENALTY_LOCAL}, {potts, QS_MULTIWAY_CUT, QS_PENALTY_LOCAL},
                 {whole_linear, QS_ST_CUT, QS_PENALTY_LOCAL}, {whole_linear, QS_ST_CUT_ARCS, QS_PENALTY_LOCAL}};
    static fixture f;
    uint64_t state = 41;
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
        for (int round = 0; round < ROUNDS / 5;) {
            int64_t gap = 1 + tiny_random(&state, 3);
            if (random_file(&f, &state, BITS - 2, kinds[kind].smoothness, (qs_encode_options){kinds[kind].encoding, kinds[kind].penalty, 0, (uint32_t)gap})) {
                repair_states(&f, gap);
                round++;
            }
        }
    }
}

/* ---- A variable an arc: given the vertices, each is decided by itself. ---- */

/* H with the arcs' variables at their best; `margin` = the least that any of them would cost at its other value. */
static int64_t best_arcs(const fixture *f, uint32_t vertices, uint64_t state, int64_t *margin)
{
    uint8_t bits[BYTES];
    to_bytes(state, bits);
    int64_t none = qs_qubo_energy(&f->index, bits), best = none;
    *margin = INT64_MAX;
    for (uint32_t z = vertices; z < f->qubo.variables; z++) {
        bits[z / 8] ^= (uint8_t)(1u << z % 8);
        int64_t change = qs_qubo_energy(&f->index, bits) - none, size = change < 0 ? -change : change;
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
        if (!random_file(&f, &state, 8 * BYTES, whole_linear, (qs_encode_options){QS_ST_CUT_ARCS, QS_PENALTY_LOCAL, 0, gap})) {
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

/* ---- Counts. ---- */

static void make_grid(fixture *f, uint32_t width, uint32_t height, uint32_t labels, int32_t weight, qs_smoothness smoothness)
{
    memset(f, 0, sizeof *f);
    uint64_t state = width * 100 + height * 10 + labels;
    for (uint32_t i = 0; i < width * height * labels; i++) {
        f->t.costs[i] = (int32_t)tiny_random(&state, 20);
    }
    f->t.problem = (qs_problem){.labels = labels, .scale = 1, .weight = weight, .grid = {.width = width, .height = height}, .costs = f->t.costs};
    f->t.problem.pairwise.smoothness = smoothness;
    make_model(f);
}

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
                     n * m * k * (k - 1) / 2 + edges * k * (k - 1) + k * k * (k - 1) / 2 + n * m * k * k * (k - 1));
        make_grid(&f, cases[i].n, cases[i].m, cases[i].k, 7, QS_TRUNCATED_LINEAR);
        check_counts(&f, QS_DOMAIN_WALL, n * m * (k - 1), n * m * (k - 2) + edges * (k - 1));
        check_counts(&f, QS_ST_CUT, n * m * k + n * m + 2, n * m * (k + 2) + (k + 1) * edges);
        check_counts(&f, QS_ST_CUT_ARCS, 7 * n * m * k + 9 * n * m - 2 * n * k - 2 * m * k - 2 * n - 2 * m + 2, 5 * (n * m * (k + 2) + (k + 1) * edges));
        f.t.problem.pairwise.truncation = 2;
        make_model(&f);
        check_counts(&f, QS_DOMAIN_WALL, n * m * (k - 1), n * m * (k - 2) + edges * (k - 1 + (k > 3 ? 2 * (k - 3) : 0)));
    }
}

/* ---- Bounds that are the least. ---- */

/* The least H of all states less min F where each penalty is `less` units smaller: `broken` says how many units of penalty a state pays. */
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

/* Up-steps of the walls of sites with three labels. */
static int64_t up_steps(const fixture *f, uint64_t state)
{
    int64_t steps = 0;
    for (uint32_t p = 0; p < f->sites; p++) {
        steps += (state >> 2 * p & 3) == 2;
    }
    return steps;
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
        make_model(&f);
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL, .gap = 1}, false), QS_OK);
        assert_int_equal(margin(&f, 1, up_steps), 0);
        assert_true(margin(&f, 0, up_steps) > 0);
        assert_true(margin(&f, 2, up_steps) < 0);
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

/* A star K(1,4): the centre is free in two labels, two leaves are bound to each (and a 2 x 3 grid whose inner sites are so): the sites with
 * two labels cost as much as they save. */
static void sparse_bounds_are_tight(void **unused)
{
    (void)unused;
    static fixture f;
    memset(&f, 0, sizeof f);
    for (uint32_t leaf = 0; leaf < 4; leaf++) {
        f.t.edges[leaf] = (qs_edge){0, leaf + 1, 100};
        f.t.costs[2 + 2 * leaf + (leaf < 2)] = 10000;
    }
    f.t.problem = (qs_problem){.sites = 5, .labels = 2, .scale = 1, .edges = f.t.edges, .edge_count = 4, .costs = f.t.costs};
    make_model(&f);
    for (uint32_t gap = 1; gap <= 6; gap += 5) {
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE, .penalty = QS_PENALTY_MINIMAL, .gap = gap}, false), QS_OK);
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
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE, .penalty = QS_PENALTY_MINIMAL, .gap = 1}, false), QS_OK);
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

/* The same star, the centre bound to one label and the leaves to the other: an empty centre costs a, a labelling W = 400. A third label that is
 * gone changes nothing, and leaves that are fixed are no concern of the centre's penalty. */
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
    f.t.problem = (qs_problem){.sites = 5, .labels = 3, .scale = 1, .edges = f.t.edges, .edge_count = 4, .costs = f.t.costs};
    make_model(&f);
    for (uint32_t fixed = 0; fixed <= 4; fixed++) {
        int64_t a, b;
        for (uint32_t p = 0; p < 5; p++) {
            f.left[p] = p > 0 && p <= fixed ? 2 : 3;
        }
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ONE_HOT, .gap = 7}, false), QS_OK);
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
        uint32_t size = encoding == QS_DOMAIN_WALL ? labels - 1 : encoding >= QS_ST_CUT ? labels + 1 : labels;
        for (uint32_t i = 0; i < size; i++) {
            bool one = encoding == QS_DOMAIN_WALL ? i < labelling[p] : encoding >= QS_ST_CUT ? i <= labelling[p] : i == labelling[p];
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
            f.t.costs[i] += 10; /* none is negative: the file of a model says no more than the sum of the least ones */
        }
        qs_encode_options options = {QS_ONE_HOT, (qs_penalty)tiny_random(&state, 4), 12345, 1 + tiny_random(&state, 4)};
        bool linear_cost = f.t.problem.pairwise.smoothness == QS_TRUNCATED_LINEAR;
        if (tiny_random(&state, 2) == 0 && (f.t.problem.pairwise.smoothness == QS_POTTS || (linear_cost && options.penalty != QS_PENALTY_PAPER))) {
            options.encoding = QS_ONE_HOT_SPARSE;
        }
        make_model(&f);
        lone += f.t.problem.pairwise.smoothness == QS_TABLE && f.source_qubo.couplings == 0;
        assert_int_equal(recode(&f, options, false), QS_OK);
        qs_buffer buffer = {direct, sizeof direct, 0};
        qs_sink sink = qs_buffer_sink(&buffer);
        assert_int_equal(qs_encode(&f.t.problem, &options, &sink, memory, sizeof memory, NULL), QS_OK);
        assert_int_equal(f.size, buffer.size);
        assert_memory_equal(f.file, direct, f.size);
    }
    assert_true(lone > 0); /* tables that couple nothing */
}

/* Walls whose label sets do not overlap couple nothing, but for the weight that repair asks for. */
static void walls_apart_can_be_repaired(void **unused)
{
    (void)unused;
    static fixture f;
    for (uint64_t first = 1; first < 16; first++) {
        for (uint64_t second = 1; second < 16; second++) {
            make_grid(&f, 2, 1, 4, 5, QS_TRUNCATED_LINEAR);
            memset(f.t.costs, 0, sizeof f.t.costs); /* of which the chains' kappa would come to more than the edge costs */
            make_model(&f);
            f.left[0] = first;
            f.left[1] = second;
            assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL}, false), QS_OK);
            repair_states(&f, 1);
        }
    }
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
            assert_int_equal(qs_encode(&f.t.problem, &options, &sink, memory, sizeof memory, NULL), QS_OK);
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
        assert_int_equal(f.qubo.labels.open, 0);
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
    f.t.problem = (qs_problem){.sites = SITES, .labels = MANY, .scale = 1, .edges = f.t.edges, .edge_count = 2, .costs = costs};
    make_model(&f);
    kept[299] = 1; /* of site 0 that label alone */
    for (int i = 0; i < 3; i++) {
        kept[MANY + three[i]] = 1;
    }
    static uint64_t memory[MEMORY / 8];
    qs_recode_options options = {.encode.encoding = QS_ONE_HOT_SPARSE, .kept = kept};
    qs_buffer buffer = {f.file, sizeof f.file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_int_equal(qs_recode(&f.model, &f.source_qubo, &options, &sink, memory, sizeof memory, NULL), QS_OK);
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

/* What fixed neighbours add to a cost may be too much for a model; then no encoding that a model is built from is written. */
static void costs_beyond_a_model(void **unused)
{
    (void)unused;
    static fixture f;
    static uint64_t memory[MEMORY / 8];
    qs_model model;
    const qs_encoding encodings[] = {QS_ONE_HOT, QS_ONE_HOT_SPARSE, QS_DOMAIN_WALL, QS_MULTIWAY_CUT, QS_ST_CUT, QS_ST_CUT_ARCS};
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
        assert_int_equal(recode(&f, (qs_encode_options){QS_DOMAIN_WALL, fixed[i], 9, 0}, false), QS_E_ENCODING);
        assert_int_equal(recode(&f, (qs_encode_options){QS_MULTIWAY_CUT, fixed[i], 9, 0}, false), QS_OK);
    }
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ST_CUT}, false), QS_E_ENCODING);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ST_CUT_ARCS + 1}, false), QS_E_ARGUMENT);
    assert_int_equal(recode(&f, (qs_encode_options){.penalty = QS_PENALTY_MINIMAL + 1}, false), QS_E_ARGUMENT);
    assert_int_equal(recode(&f, (qs_encode_options){.penalty = QS_PENALTY_GIVEN}, false), QS_E_ARGUMENT);
    assert_int_equal(recode(&f, (qs_encode_options){.penalty = QS_PENALTY_GIVEN, .alpha = INT64_MAX}, false), QS_E_OVERFLOW);
    assert_int_equal(recode(&f, (qs_encode_options){.penalty = QS_PENALTY_GIVEN, .alpha = (int64_t)1 << 50}, false), QS_E_OVERFLOW);
    /* M = 4 sites x (4 a + 3 b) and some more, b = 2 a. */
    assert_int_equal(recode(&f, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_GIVEN, QS_ENERGY_MAX / 40, 0}, false), QS_E_OVERFLOW);
    assert_int_equal(recode(&f, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_GIVEN, QS_ENERGY_MAX / 41, 0}, false), QS_OK);
    /* kappa is a weight of 32 bits. */
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL, .gap = INT32_MAX}, false), QS_E_OVERFLOW);
    f.left[3] = 0;
    assert_int_equal(recode(&f, (qs_encode_options){0}, false), QS_E_ARGUMENT);
    make_grid(&f, 2, 2, 3, 5, QS_TRUNCATED_LINEAR);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_MULTIWAY_CUT}, false), QS_E_ENCODING);
    assert_int_equal(recode(&f, (qs_encode_options){QS_ST_CUT, QS_PENALTY_PAPER, 0, 0}, false), QS_E_ENCODING);
    assert_int_equal(recode(&f, (qs_encode_options){QS_ONE_HOT_SPARSE, QS_PENALTY_PAPER, 0, 0}, false), QS_E_ENCODING);
    f.t.problem.pairwise.truncation = 1;
    make_model(&f);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ST_CUT_ARCS}, false), QS_E_ENCODING);
    make_grid(&f, 2, 2, 3, 5, QS_TRUNCATED_QUADRATIC);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_DOMAIN_WALL}, false), QS_E_ENCODING);
    assert_int_equal(recode(&f, (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE}, false), QS_E_ENCODING);
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
            status = qs_recode(&f.model, &f.source_qubo, &(qs_recode_options){.encode.encoding = encoding}, &sink, memory, sizeof memory, NULL);
            assert_true(status == QS_E_IO || status == QS_OK);
            assert_true(calls < 1000);
        }
        assert_true(calls > 7);
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
        cmocka_unit_test(multiway_cut),
        cmocka_unit_test(st_cut),
        cmocka_unit_test(what_is_written_can_be_repaired),
        cmocka_unit_test(walls_apart_can_be_repaired),
        cmocka_unit_test(masked_rows_are_runs_of_their_own),
        cmocka_unit_test(st_cut_arcs),
        cmocka_unit_test(counts_by_formula),
        cmocka_unit_test(wall_bounds_are_tight),
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
    return cmocka_run_group_tests_name("recode", tests, NULL, NULL);
}
