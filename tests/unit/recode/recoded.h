/* Files that qs_recode writes, and what docs/FORMAT.md says that they mean: what test_recode.c and
 * test_recode_bounds.c share. */
#ifndef RECODED_H
#define RECODED_H

#include "tiny.h"

#include <stdlib.h>
#include <string.h>

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

static inline void open_file(const uint8_t *file, size_t size, qs_qubo *qubo, uint64_t *memory,
                             qs_index *index)
{
    assert_int_equal(qs_qubo_open(file, size, MEMORY, qubo, NULL), QS_OK);
    assert_int_equal(qs_index_build(qubo, memory, MEMORY, index), QS_OK);
}

/* The model of f->t.problem, by way of the file that qs_encode makes; all labels are left. */
static inline void make_model(fixture *f)
{
    const qs_problem *p = &f->t.problem;
    static uint64_t memory[MEMORY / 8];
    qs_buffer buffer = {f->source, sizeof f->source, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_int_equal(qs_encode(p, &(qs_encode_options){.encoding = QS_ONE_HOT}, &sink, memory,
                               sizeof memory, NULL),
                     QS_OK);
    f->source_size = buffer.size;
    open_file(f->source, f->source_size, &f->source_qubo, f->source_memory, &f->source_index);
    assert_int_equal(
        qs_model_build(&f->source_index, f->model_memory, sizeof f->model_memory, &f->model),
        QS_OK);
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
static inline void draw_labels(fixture *f, uint64_t *state)
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

static inline bool has(const fixture *f, uint32_t site, uint32_t label)
{
    return (f->left[site] >> label & 1) != 0;
}

static inline qs_status recode(fixture *f, qs_encode_options options, bool truncate)
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
    qs_recode_options recode_options = {
        .encode = options, .truncate = truncate, .kept = all ? NULL : f->kept};
    size_t size = qs_recode_workspace(&f->model, &recode_options);
    void *workspace =
        malloc(size + !size); /* of that very size: the sanitizer sees a byte too many */
    qs_buffer buffer = {f->file, sizeof f->file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    uint64_t told = 0, counted = 0;
    qs_status status = qs_recode(&f->model, &f->source_qubo.labels, &recode_options, &sink,
                                 workspace, size, &told);
    if (status == QS_OK) {
        assert_int_equal(qs_recode(&f->model, &f->source_qubo.labels, &recode_options, NULL,
                                   workspace, size, &counted),
                         QS_OK);
        assert_int_equal(told, buffer.size);
        assert_int_equal(counted, told);
        if (size > 0) {
            assert_int_equal(qs_recode(&f->model, &f->source_qubo.labels, &recode_options, NULL,
                                       workspace, size - 1, NULL),
                             QS_E_WORKSPACE);
        }
        f->size = buffer.size;
        open_file(f->file, f->size, &f->qubo, f->memory, &f->index);
    }
    free(workspace);
    return status;
}

static inline void make_grid(fixture *f, uint32_t width, uint32_t height, uint32_t labels,
                             int32_t weight, qs_smoothness smoothness)
{
    memset(f, 0, sizeof *f);
    uint64_t state = width * 100 + height * 10 + labels;
    for (uint32_t i = 0; i < width * height * labels; i++) {
        f->t.costs[i] = (int32_t)tiny_random(&state, 20);
    }
    f->t.problem = (qs_problem){.labels = labels,
                                .scale = 1,
                                .weight = weight,
                                .grid = {.width = width, .height = height},
                                .costs = f->t.costs};
    f->t.problem.pairwise.smoothness = smoothness;
    make_model(f);
}

/* ---- Meaning, from docs/FORMAT.md's table. ---- */

static inline uint32_t count_labels(const fixture *f, uint32_t site)
{
    uint32_t count = 0;
    for (uint32_t d = 0; d < f->t.problem.labels; d++) {
        count += has(f, site, d);
    }
    return count;
}

static inline uint32_t nth_label(const fixture *f, uint32_t site, uint32_t n)
{
    for (uint32_t d = 0;; d++) {
        if (has(f, site, d) && n-- == 0) {
            return d;
        }
    }
}

static inline bool is_open(const fixture *f, uint32_t site)
{
    bool plain = f->t.problem.labels == 1 && f->qubo.labels.encoding <= QS_ONE_HOT_SPARSE;
    return plain || count_labels(f, site) > 1;
}

/* The number of the only 1 among `count` bits; `count` = it is not so. */
static inline uint32_t only_one(uint64_t bits, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (bits == (uint64_t)1 << i) {
            return i;
        }
    }
    return count;
}

/* The number of ones where all of them stand first; UINT32_MAX = it is not so. */
static inline uint32_t leading_ones(uint64_t bits, uint32_t count)
{
    for (uint32_t ones = 0; ones <= count; ones++) {
        if (bits == ((uint64_t)1 << ones) - 1) {
            return ones;
        }
    }
    return UINT32_MAX;
}

static inline uint64_t cut_out(uint64_t state, uint32_t *at, uint32_t count)
{
    uint64_t bits = state >> *at & (((uint64_t)1 << count) - 1);
    *at += count;
    return bits;
}

/* The labelling that a state of at most 63 variables stands for, without those of arcs; false if
 * none. `extra` = what truncation has taken from its costs. */
static inline bool decode(const fixture *f, uint64_t state, uint16_t *labelling, int64_t *extra)
{
    qs_encoding encoding = f->qubo.labels.encoding;
    uint32_t at = 0, trimmed = 0, open = 0, labels = f->t.problem.labels;
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
            index = leading_ones(cut_out(state, &at, n + 1), n) -
                    1; /* of none at all: UINT32_MAX - 1 or - 2 */
        } else {
            index = only_one(cut_out(state, &at, n), n);
        }
        if (index >= n) {
            return false;
        }
        labelling[p] = (uint16_t)nth_label(f, p, index);
        for (unsigned b = 0; b < l->trimmed_bytes; b++) {
            *extra += (int64_t)l->trimmed[(trimmed + index) * l->trimmed_bytes + b] << 8 * b;
        }
        trimmed += n;
        open++;
    }
    for (uint32_t t = 0; encoding == QS_MULTIWAY_CUT && open > 0 && t < labels; t++) {
        if (only_one(cut_out(state, &at, labels), labels) != t) {
            return false;
        }
    }
    return encoding < QS_ST_CUT || open == 0 || cut_out(state, &at, 2) == 1;
}

static inline void to_bytes(uint64_t state, uint8_t bits[BYTES])
{
    memset(bits, 0, BYTES);
    for (int i = 0; i < 8; i++) {
        bits[i] = (uint8_t)(state >> 8 * i);
    }
}

static inline int64_t energy_of(const fixture *f, uint64_t state)
{
    uint8_t bits[BYTES];
    to_bytes(state, bits);
    return qs_qubo_energy(&f->index, bits);
}

static inline int64_t problem_energy(const fixture *f, const uint16_t *labelling)
{
    int64_t energy;
    assert_int_equal(qs_problem_energy(&f->t.problem, labelling, NULL, 0, &energy), QS_OK);
    return energy;
}

/* The least F over the labellings of the labels left, and how many such labellings there are. */
static inline int64_t least_energy(const fixture *f, uint64_t *labellings)
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
static inline void check_kept(const fixture *f, bool all)
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
    assert_int_equal(l->undecided, open);
}

static inline void check_file(const fixture *f)
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
    int64_t least; /* H of any labelling, */
    int64_t extra; /* and the most that truncation has taken from one of that H: those are to be the
                      optima */
    int64_t invalid; /* H of any other state */
    uint64_t labellings;
    uint32_t stuck; /* other states that no flip lowers by the gap */
} sweep;

static inline sweep sweep_states(const fixture *f, int64_t gap)
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

static inline void check_states(const fixture *f, int64_t gap, bool flips)
{
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

static inline void any_smoothness(fixture *f, uint64_t *state)
{
    (void)f;
    (void)state;
}

static inline void potts(fixture *f, uint64_t *state)
{
    (void)state;
    f->t.problem.pairwise.smoothness = QS_POTTS;
}

static inline void linear(fixture *f, uint64_t *state)
{
    f->t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_LINEAR, tiny_random(state, 5), NULL};
}

static inline void whole_linear(fixture *f, uint64_t *state)
{
    uint32_t labels = f->t.problem.labels;
    f->t.problem.pairwise = (qs_pairwise){
        QS_TRUNCATED_LINEAR, tiny_random(state, 2) ? 0 : labels - 1 + tiny_random(state, 2), NULL};
}

static inline void quadratic(fixture *f, uint64_t *state)
{
    f->t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_QUADRATIC, tiny_random(state, 6), NULL};
}

static inline void whole_quadratic(fixture *f, uint64_t *state)
{
    (void)state;
    f->t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_QUADRATIC, 0, NULL};
}

static inline void table(fixture *f, uint64_t *state)
{
    (void)state;
    f->t.problem.pairwise = (qs_pairwise){QS_TABLE, 0, f->t.table};
}

/* Entries that are 0 or large: the worst for walls. */
static inline void steep_table(fixture *f, uint64_t *state)
{
    for (size_t i = 0; i < sizeof f->t.table / sizeof *f->t.table; i++) {
        f->t.table[i] = tiny_random(state, 2) ? 20 : 0;
    }
    table(f, state);
}

/* A random file of at most `bits` variables; false = it has more. */
static inline bool random_file(fixture *f, uint64_t *state, uint32_t bits,
                               void (*smoothness)(fixture *, uint64_t *), qs_encode_options options)
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

static inline void many(uint64_t seed, uint32_t bits, void (*smoothness)(fixture *, uint64_t *),
                        qs_encoding encoding, qs_penalty penalty, bool flips)
{
    static fixture f;
    uint64_t state = seed;
    for (int round = 0; round < ROUNDS;) {
        uint32_t gap = penalty == QS_PENALTY_LOCAL || penalty == QS_PENALTY_MINIMAL
                           ? 1 + tiny_random(&state, 3)
                           : 1;
        if (random_file(&f, &state, bits, smoothness,
                        (qs_encode_options){encoding, penalty, 0, gap})) {
            assert_int_equal(f.qubo.labels.encoding, encoding);
            assert_int_equal(f.qubo.labels.penalty, penalty);
            assert_int_equal(f.qubo.labels.gap, gap);
            check_states(&f, gap, flips);
            round++;
        }
    }
}

#endif
