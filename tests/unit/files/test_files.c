/* Both file formats: what is written is read back; every truncation, every flipped bit and every
 * breach of FORMAT.md is refused with the right status. */
#include "slow.h"

#include <string.h>

#include "base/bytes.h"
#include "files/crc32c.h"

enum { HEADER = 64 };

static tiny_qubo q;

static void sample_problem(tiny *t)
{
    memset(t, 0, sizeof *t);
    for (int i = 0; i < 6; i++) {
        t->mask[i] = i != 4;
        t->right[i] = i;
        t->down[i] = 300;
    }
    for (int i = 0; i < 15; i++) {
        t->costs[i] = i * 100;
    }
    t->problem = (qs_problem){.labels = 3,
                              .scale = 2,
                              .weight = 7,
                              .grid = {3, 2, t->mask, t->right, t->down},
                              .costs = t->costs,
                              .frame = {10, 20, 4, 5, 6}};
}

static qs_status open_qubo(const uint8_t *file, size_t size)
{
    qs_qubo qubo;
    uint64_t memory[TINY_INDEX / 8];
    qs_status status = qs_qubo_open(file, size, TINY_INDEX, &qubo, NULL);
    qs_index index;
    return status == QS_OK ? qs_index_build(&qubo, memory, sizeof memory, &index) : status;
}

static qs_status open_samples(const uint8_t *file, size_t size)
{
    qs_samples_view view;
    return qs_samples_open(file, size, &view, NULL);
}

static void round_trip(void **unused)
{
    (void)unused;
    tiny t;
    sample_problem(&t);
    tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 3}, &q);
    const qs_labels *l = &q.qubo.labels;
    assert_int_equal(q.qubo.groups, 5);
    assert_int_equal(q.qubo.variables, 15);
    assert_true(q.qubo.has_labels);
    assert_int_equal(l->encoding, QS_ONE_HOT);
    assert_int_equal(l->penalty, QS_PENALTY_LOCAL);
    assert_int_equal(l->gap, 3);
    assert_int_equal(l->scale, 2);
    assert_int_equal(l->weight, -1);
    assert_int_equal(l->labels, 3);
    assert_int_equal(l->width, 3);
    assert_int_equal(l->height, 2);
    assert_memory_equal(&l->frame, &t.problem.frame, sizeof l->frame);
    assert_int_equal(l->mask[0], 0x2f);
    /* Sites 0, 1, 2, 3, 5 of the cells: right 0-1, 1-2 (cell 4 is masked), down 0-3, 2-5. */
    assert_int_equal(q.qubo.couplings, 4);
    assert_int_equal(q.index.near_start[1], 2);
    assert_int_equal(q.index.near[0].group, 1);
    assert_int_equal(q.index.near[0].weight, 0);
    assert_int_equal(q.index.near[1].group, 3);
    assert_int_equal(q.index.near[1].weight, 300);
    assert_int_equal(qs_qubo_linear(&q.qubo, 14), 200);
}

static void sizing_pass_tells_the_size(void **unused)
{
    (void)unused;
    uint64_t state = 9, memory[8192], size;
    for (int round = 0; round < 300; round++) {
        tiny t;
        tiny_make(&t, &state, 24, round % 2 == 0);
        tiny_encode(&t.problem, (qs_encode_options){0}, &q);
        assert_int_equal(
            qs_encode(&t.problem, &(qs_encode_options){0}, NULL, memory, sizeof memory, &size),
            QS_OK);
        assert_int_equal(size, q.size);
    }
}

static void truncations(const uint8_t *file, size_t size,
                        qs_status (*open)(const uint8_t *, size_t))
{
    for (size_t cut = 0; cut < size; cut++) {
        assert_int_equal(open(file, cut), QS_E_TRUNCATED);
    }
}

static void flips(uint8_t *file, size_t size, qs_status (*open)(const uint8_t *, size_t))
{
    for (size_t bit = 0; bit < 8 * size; bit++) {
        file[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_int_equal(open(file, size), bit < 64 ? QS_E_FORMAT : QS_E_CORRUPT);
        file[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_int_equal(open(file, size), QS_OK);
}

static void damaged_qubos(void **unused)
{
    (void)unused;
    uint64_t state = 11;
    for (int round = 0; round < 12; round++) {
        tiny t;
        tiny_make(&t, &state, 24, false);
        tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 0}, &q);
        truncations(q.file, q.size, open_qubo);
        flips(q.file, q.size, open_qubo);
    }
}

/* Rewrites the checks of a file whose contents have been changed. */
static void seal(uint8_t *file, size_t size)
{
    qs_store_u32(file + 60, qs_crc32c_portable(0, file, 60));
    for (size_t at = HEADER; at + 20 <= size;) {
        size_t covered = 16 + (size_t)qs_load_u64(file + at + 8);
        if (covered + 4 > size - at) {
            return;
        }
        qs_store_u32(file + at + covered, qs_crc32c_portable(0, file + at, covered));
        at += covered + 4;
    }
}

static size_t payload(const uint8_t *file, size_t size, const char *type)
{
    for (size_t at = HEADER; at < size; at += 20 + (size_t)qs_load_u64(file + at + 8)) {
        if (memcmp(file + at, type, 4) == 0) {
            return at + 16;
        }
    }
    fail_msg("no chunk %s", type);
    return 0;
}

typedef struct breach {
    const char *chunk; /* NULL: the header */
    size_t at;
    uint32_t value;
    qs_status status;
} breach;

static void expect_breaches(const uint8_t *file, size_t size, const breach *breaches, size_t count,
                            qs_status (*open)(const uint8_t *, size_t))
{
    uint8_t copy[TINY_FILE];
    for (size_t i = 0; i < count; i++) {
        memcpy(copy, file, size);
        size_t base = breaches[i].chunk ? payload(file, size, breaches[i].chunk) : 0;
        qs_store_u32(copy + base + breaches[i].at, breaches[i].value);
        seal(copy, size);
        if (open(copy, size) != breaches[i].status) {
            fail_msg("breach %zu (%s + %zu = %u): %s", i,
                     breaches[i].chunk ? breaches[i].chunk : "header", breaches[i].at,
                     breaches[i].value, qs_status_text(open(copy, size)));
        }
    }
}

static void broken_promises(void **unused)
{
    (void)unused;
    tiny t;
    sample_problem(&t);
    tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 3}, &q);
    const breach breaches[] = {
        {NULL, 8, 2, QS_E_UNSUPPORTED},
        {NULL, 12, 6, QS_E_CORRUPT},
        {NULL, 12, 8, QS_E_CORRUPT},
        {NULL, 16, (uint32_t)q.size - 1, QS_E_CORRUPT},
        {NULL, 16, (uint32_t)q.size + 1, QS_E_TRUNCATED},
        {NULL, 24, 14, QS_E_CORRUPT},
        {NULL, 24, 0, QS_E_CORRUPT},
        {NULL, 24, 0x80000000, QS_E_CORRUPT},
        {NULL, 28, 4, QS_E_CORRUPT},
        {NULL, 28, 0, QS_E_CORRUPT},
        {NULL, 28, 16, QS_E_CORRUPT},
        {NULL, 32, 3, QS_E_CORRUPT},
        {NULL, 32, 5, QS_E_CORRUPT},
        {NULL, 32, 0x7fffffff, QS_E_LIMIT},
        {NULL, 40, 1, QS_E_CORRUPT},
        {NULL, 56, 1, QS_E_CORRUPT},
        {"GRPS", 0, 4, QS_E_CORRUPT},
        {"GRPS", 0, 0, QS_E_CORRUPT},
        {"GRPS", 4, 0, QS_E_CORRUPT},
        {"BLKS", 0, 2, QS_E_CORRUPT},
        {"BLKS", 0, 0, QS_E_CORRUPT},
        {"BLKS", 4, 0, QS_E_CORRUPT},
        {"BLKS", 4, 2, QS_E_CORRUPT},
        {"BLKS", 8, 4, QS_E_CORRUPT},
        {"BLKS", 12, 2, QS_E_CORRUPT},
        {"BLKS", 20, (uint32_t)-3, QS_E_CORRUPT},
        {"BLKS", 20, 3, QS_E_CORRUPT},
        {"CPLS", 0, 2, QS_E_CORRUPT},
        {"CPLS", 0, 4, QS_E_CORRUPT},
        {"CPLS", 4, 1, QS_E_CORRUPT},
        {"CPLS", 8, 2, QS_E_CORRUPT},
        {"CPLS", 12, 3, QS_E_CORRUPT},
        {"CPLS", 12, 8, QS_E_CORRUPT},
        {"CPLS", 12, 0, QS_E_CORRUPT},
        {"CPLS", 16, 1, QS_E_CORRUPT},
        {"CPLS", 20, 4, QS_E_CORRUPT},
        {"CPLS", 24, 9, QS_E_CORRUPT},
        {"CPLS", 28, 0, QS_E_CORRUPT},
        {"CPLS", 32, 0, QS_E_CORRUPT},
        {"CPLS", 36, 1, QS_E_CORRUPT},
        {"LINR", 8, 3, QS_E_CORRUPT},
        {"LINR", 8, 4, QS_E_CORRUPT},
        {"LINR", 12, 1, QS_E_CORRUPT},
        {"LINR", 4, 0x00300000, QS_E_CORRUPT},
        {"LINR", 4, 0x7fffffff, QS_E_CORRUPT},
        {"PNLT", 0, 3, QS_E_CORRUPT},
        {"PNLT", 0, 4, QS_E_CORRUPT},
        {"PNLT", 4, 1, QS_E_CORRUPT},
        {"PNLT", 8, 0, QS_E_CORRUPT},
        {"PNLT", 8, 6, QS_E_CORRUPT},
        {"OFFS", 4, 0x00300000, QS_E_CORRUPT},
        {"labl", 0, 0, QS_E_CORRUPT},
        {"labl", 0, 3, QS_E_CORRUPT},
        {"labl", 0, 7, QS_E_CORRUPT},
        {"labl", 4, 5, QS_E_CORRUPT},
        {"labl", 12, 4, QS_E_CORRUPT},
        {"labl", 16, 0, QS_E_CORRUPT},
        {"labl", 20, 4, QS_E_CORRUPT},
        {"labl", 24, 0, QS_E_CORRUPT},
        {"labl", 28, (uint32_t)-2, QS_E_CORRUPT},
        {"labl", 32, 0, QS_E_CORRUPT},
        {"labl", 32, 2, QS_E_CORRUPT},
        {"labl", 36, 3, QS_E_CORRUPT},
        {"labl", 40, 6, QS_E_CORRUPT},
        {"labl", 48, 8, QS_E_CORRUPT},
        {"labl", 56, 0x80000000, QS_E_CORRUPT},
        {"labl", 60, 2, QS_E_CORRUPT},
        {"labl", 60, 0, QS_E_CORRUPT},
    };
    expect_breaches(q.file, q.size, breaches, sizeof breaches / sizeof *breaches, open_qubo);
    uint8_t *mask = q.file + payload(q.file, q.size, "labl") + 64;
    for (uint8_t wrong = 0; wrong < 2; wrong++) {
        uint8_t right = *mask;
        *mask = wrong ? 0x6f : 0x3f; /* a spare bit; a site too many */
        seal(q.file, q.size);
        assert_int_equal(open_qubo(q.file, q.size), QS_E_CORRUPT);
        *mask = right;
    }
}

/* Five sites of three labels, one fixed, some labels gone, some costs cut. */
static slow_qubo reduced;

static void write_reduced(qs_encoding encoding, bool whole)
{
    static tiny t;
    sample_problem(&t);
    t.problem.pairwise.smoothness = encoding >= QS_ST_CUT ? QS_TRUNCATED_LINEAR : QS_POTTS;
    slow_request request = {
        .problem = &t.problem, .encoding = encoding, .gap = 1, .truncate = true};
    static const uint16_t best[5] = {1, 2, 2, 1, 0}; /* of kept labels the numbers 1 - 1 0 0 */
    const uint8_t sets[5] = {7, 4, 5, 6, 7};
    request.best = encoding <= QS_DOMAIN_WALL && !whole ? best : NULL;
    request.lower_bound = -5;
    for (uint32_t p = 0; p < 5; p++) {
        for (uint32_t d = 0; d < 3; d++) {
            request.kept[p][d] = whole || sets[p] >> d & 1;
            t.costs[p * 3 + d] = d == 1 ? 100000 : (int32_t)(d + p);
        }
    }
    slow_encode(&request, &reduced);
}

/* Fields that mean something only beside another one. */
static void fields_beside_others(void **unused)
{
    (void)unused;
    enum { V = 4, TRUNCATION = 8, PENALTY = 20, GAP = 24 };
    static const struct {
        qs_encoding encoding;
        qs_smoothness smoothness;
        uint32_t truncation;
        qs_penalty penalty;
        uint32_t gap;
        qs_status status;
    } cases[] = {
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_LOCAL, 3, QS_OK},
        {QS_ONE_HOT, QS_POTTS, 1, QS_PENALTY_LOCAL, 3, QS_E_CORRUPT},
        {QS_ONE_HOT, QS_TABLE, 1, QS_PENALTY_LOCAL, 3, QS_E_CORRUPT},
        {QS_ONE_HOT, QS_TABLE, 0, QS_PENALTY_LOCAL, 3, QS_OK},
        {QS_ONE_HOT, QS_TRUNCATED_QUADRATIC, 1, QS_PENALTY_LOCAL, 3, QS_OK},
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_PAPER, 3, QS_E_CORRUPT},
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_GIVEN, 3, QS_E_CORRUPT},
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_PAPER, 1, QS_OK},
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_MINIMAL, 3, QS_OK},
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_LOCAL, INT32_MAX, QS_OK},
        {QS_ONE_HOT, QS_POTTS, 0, QS_PENALTY_LOCAL, INT32_MAX + 1u, QS_E_CORRUPT},
        {QS_ONE_HOT_SPARSE, QS_TRUNCATED_LINEAR, 1, QS_PENALTY_LOCAL, 1, QS_OK},
        {QS_ONE_HOT_SPARSE, QS_TRUNCATED_LINEAR, 1, QS_PENALTY_GIVEN, 1, QS_OK},
        {QS_ONE_HOT_SPARSE, QS_TRUNCATED_LINEAR, 1, QS_PENALTY_PAPER, 1, QS_E_CORRUPT},
        {QS_ONE_HOT_SPARSE, QS_TRUNCATED_QUADRATIC, 1, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_ONE_HOT_SPARSE, QS_TABLE, 0, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_DOMAIN_WALL, QS_TRUNCATED_LINEAR, 1, QS_PENALTY_LOCAL, 1, QS_OK},
        {QS_DOMAIN_WALL, QS_TRUNCATED_QUADRATIC, 0, QS_PENALTY_LOCAL, 1, QS_OK},
        {QS_DOMAIN_WALL, QS_TABLE, 0, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_DOMAIN_WALL, QS_POTTS, 0, QS_PENALTY_PAPER, 1, QS_E_CORRUPT},
        {QS_DOMAIN_WALL, QS_POTTS, 0, QS_PENALTY_GIVEN, 1, QS_E_CORRUPT},
        {QS_MULTIWAY_CUT, QS_POTTS, 0, QS_PENALTY_GIVEN, 1, QS_OK},
        {QS_MULTIWAY_CUT, QS_TRUNCATED_LINEAR, 0, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_ST_CUT, QS_TRUNCATED_LINEAR, 2, QS_PENALTY_LOCAL, 1, QS_OK},
        {QS_ST_CUT, QS_TRUNCATED_LINEAR, 1, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_ST_CUT, QS_POTTS, 0, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_ST_CUT_ARCS, QS_TRUNCATED_LINEAR, 0, QS_PENALTY_LOCAL, 1, QS_OK},
        {QS_ST_CUT_ARCS, QS_TRUNCATED_QUADRATIC, 0, QS_PENALTY_LOCAL, 1, QS_E_CORRUPT},
        {QS_ST_CUT_ARCS, QS_TRUNCATED_LINEAR, 0, QS_PENALTY_GIVEN, 1, QS_E_CORRUPT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_reduced(cases[i].encoding, true);
        uint8_t *labl = reduced.file + payload(reduced.file, reduced.size, "labl");
        qs_store_u32(labl + V, cases[i].smoothness);
        qs_store_u32(labl + TRUNCATION, cases[i].truncation);
        qs_store_u32(labl + PENALTY, cases[i].penalty);
        qs_store_u32(labl + GAP, cases[i].gap);
        seal(reduced.file, reduced.size);
        if (open_qubo(reduced.file, reduced.size) != cases[i].status) {
            fail_msg("case %zu is not: %s", i, qs_status_text(cases[i].status));
        }
    }
}

/* What only a grid has. A mask of no cells would point behind the file. */
static void grids_alone_have_masks_and_pictures(void **unused)
{
    (void)unused;
    static const qs_edge edges[] = {{0, 1, 5}, {1, 2, 5}};
    static const int32_t costs[6] = {0, 3, 1, 0, 2, 0};
    qs_problem problem = {
        .sites = 3, .labels = 2, .scale = 1, .edges = edges, .edge_count = 2, .costs = costs};
    tiny_encode(&problem, (qs_encode_options){0}, &q);
    const breach breaches[] = {
        {"labl", 60, 0, QS_OK},          {"labl", 60, 1, QS_E_CORRUPT},
        {"labl", 40, 1, QS_E_CORRUPT},   {"labl", 44, 1, QS_E_CORRUPT},
        {"labl", 48, 1, QS_E_CORRUPT},   {"labl", 52, 1, QS_E_CORRUPT},
        {"labl", 56, 1, QS_OK},          {"labl", 56, (uint32_t)-5, QS_OK},
        {"labl", 56, 0x80000001, QS_OK}, {"labl", 56, 0x80000000, QS_E_CORRUPT},
    };
    expect_breaches(q.file, q.size, breaches, sizeof breaches / sizeof *breaches, open_qubo);
    problem.frame = (qs_frame){.picture_width = 5, .picture_height = 5};
    assert_int_equal(qs_problem_check(&problem), QS_E_ARGUMENT);
}

/* The rows of a lattice do not overlap, so that no run names more pairs than there are groups. */
static void lattices_name_a_pair_once(void **unused)
{
    (void)unused;
    static const int32_t costs[12] = {0};
    qs_problem problem = {
        .labels = 2, .scale = 1, .weight = 3, .grid = {.width = 3, .height = 2}, .costs = costs};
    tiny_encode(&problem, (qs_encode_options){0}, &q);
    const breach breaches[] = {
        {"CPLS", 4 + 32, 3, QS_OK},
        {"CPLS", 4 + 32, 2, QS_OK}, /* as many as a row has pairs */
        {"CPLS", 4 + 32, 1, QS_E_CORRUPT},
        {"CPLS", 4 + 32, 0, QS_E_CORRUPT},
    };
    expect_breaches(q.file, q.size, breaches, sizeof breaches / sizeof *breaches, open_qubo);
}

/* What labels stand for goes through a file and comes back; each field has its range. */
static void meanings(void **unused)
{
    (void)unused;
    static const qs_meaning known[] = {{QS_MEANS_NUMBER, 0, 0, 0, 0, 0},
                                       {QS_MEANS_GREY, 255, 0, 0, 0, 0},
                                       {QS_MEANS_CLASS, 0, 0, 0, 0, 0},
                                       {QS_MEANS_KEEP, 0, 0, 0, 0, 0},
                                       {QS_MEANS_DISPLACEMENT, 8, 21, 4, -(1 << 24), 1 << 24}};
    const breach breaches[] = {
        {"mean", 0, 0, QS_E_CORRUPT},
        {"mean", 0, 1, QS_E_CORRUPT},
        {"mean", 0, 2, QS_E_CORRUPT},
        {"mean", 0, 6, QS_E_CORRUPT},
        {"mean", 4, 0, QS_E_CORRUPT},
        {"mean", 4, 65536, QS_E_CORRUPT},
        {"mean", 8, 0, QS_E_CORRUPT},
        {"mean", 8, 65536, QS_E_CORRUPT},
        {"mean", 12, 0, QS_E_CORRUPT},
        {"mean", 12, 65536, QS_E_CORRUPT},
        {"mean", 20, (1 << 24) + 1, QS_E_CORRUPT},
        {"mean", 16, (uint32_t)-(1 << 24) - 1, QS_E_CORRUPT},
        {"mean", 4, 65535, QS_OK},
        {"mean", 8, 65535, QS_OK},
        {"mean", 12, 65535, QS_OK},
        {"labl", 56, 3, QS_OK},
        {"labl", 56, (uint32_t)-3, QS_E_CORRUPT}, /* only disparities are below 0 */
    };
    tiny t;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        sample_problem(&t);
        t.problem.meaning = known[i];
        tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 3}, &q);
        assert_memory_equal(&q.qubo.labels.meaning, &known[i], sizeof known[i]);
    }
    expect_breaches(q.file, q.size, breaches, sizeof breaches / sizeof *breaches, open_qubo);
    t.problem.frame.first = -3;
    assert_int_equal(qs_problem_check(&t.problem), QS_E_ARGUMENT);
    t.problem.meaning = (qs_meaning){QS_MEANS_DISPARITY, 0, 0, 0, 0, 0};
    assert_int_equal(qs_problem_check(&t.problem), QS_OK);
    t.problem.frame.first = INT32_MIN;
    assert_int_equal(qs_problem_check(&t.problem), QS_E_ARGUMENT);
    t.problem.frame.first = 0;
    t.problem.meaning.unit = 1;
    assert_int_equal(qs_problem_check(&t.problem), QS_E_ARGUMENT);
    t.problem.meaning.unit = 65535; /* parts of a pixel */
    assert_int_equal(qs_problem_check(&t.problem), QS_OK);
    t.problem.meaning.unit = 65536;
    assert_int_equal(qs_problem_check(&t.problem), QS_E_ARGUMENT);
}

/* Chunks of types that are not listed: a lower-case one is skipped, an upper-case one is a later
 * version's. */
static void strange_chunks(void **unused)
{
    (void)unused;
    static const struct {
        const char *type;
        qs_status status;
    } cases[] = {{"note", QS_OK},         {"NOTE", QS_E_UNSUPPORTED}, {"LINR", QS_E_CORRUPT},
                 {"n\0te", QS_E_CORRUPT}, {"labl", QS_E_CORRUPT},     {"mean", QS_E_CORRUPT}};
    tiny t;
    sample_problem(&t);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 3}, &q);
        uint8_t *chunk = q.file + q.size;
        memset(chunk, 0, 24);
        memcpy(chunk, cases[i].type, 4);
        bool labels =
            memcmp(cases[i].type, "labl", 4) == 0; /* a second one, as good as the first */
        size_t length = labels ? 64 + 1 : 3;
        if (labels) {
            memcpy(chunk, q.file + payload(q.file, q.size, "labl") - 16, 16 + length + 4);
        }
        chunk[8] = (uint8_t)length;
        q.size += 20 + length;
        qs_store_u32(q.file + 12, 8);
        qs_store_u64(q.file + 16, q.size);
        seal(q.file, q.size);
        assert_int_equal(open_qubo(q.file, q.size), cases[i].status);
    }
}

static void broken_label_sets(void **unused)
{
    (void)unused;
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        write_reduced(encoding, false);
        const breach breaches[] = {
            {"kept", 0, 4, QS_E_CORRUPT},
            {"kept", 0, 6, QS_E_CORRUPT},
            {"kept", 0, 0, QS_E_CORRUPT},
            {"kept", 4, 0, QS_E_CORRUPT},
            {"kept", 4, 2, QS_E_CORRUPT},
            {"kept", 4, 3, QS_E_CORRUPT},
            {"kept", 8, 0xffff02ff, QS_OK},
            {"kept", 8, 0xffff01ff, QS_OK},
            {"kept", 8, 0xffff03ff, QS_E_CORRUPT},
            {"kept", 8, 0xffff02fe, QS_E_CORRUPT},
            {"kept", 8, 0xff0002ff, QS_E_CORRUPT},
            {"kept", 8, 0xffffffff, QS_E_CORRUPT},
            {"kept", 13, 0x07060507, QS_OK},
            {"kept", 13, 0x07060307, QS_OK},
            {"kept", 13, 0x07060503, QS_E_CORRUPT},
            {"kept", 13, 0x07060407, QS_E_CORRUPT},
            {"kept", 13, 0x07060007, QS_E_CORRUPT},
            {"kept", 13, 0x07060d07, QS_E_CORRUPT},
            {"kept", 13, 0x07060707, QS_E_CORRUPT},
            {"kept", 13, 0x87060507, QS_E_CORRUPT},
            {"kept", 13, 0x0706050b, QS_E_CORRUPT},
            {"trnc", 0, 2, QS_E_CORRUPT},
            {"trnc", 0, 3, QS_E_CORRUPT},
            {"trnc", 0, 8, QS_E_CORRUPT},
            {"trnc", 0, 0, QS_E_CORRUPT},
            {"trnc", 4, 1, QS_E_CORRUPT},
            {"trnc", 8, 77, QS_OK},
        };
        expect_breaches(reduced.file, reduced.size, breaches, sizeof breaches / sizeof *breaches,
                        open_qubo);
        if (encoding == QS_DOMAIN_WALL) {
            truncations(reduced.file, reduced.size, open_qubo);
            flips(reduced.file, reduced.size, open_qubo);
        }
    }
}

/* A chunk best: bound, width, reserved field, and of each group a number, of two groups beyond the
 * labels that are left. */
static void broken_best(void **unused)
{
    (void)unused;
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_DOMAIN_WALL; encoding++) {
        write_reduced(encoding, false);
        const breach breaches[] = {
            {"best", 4, 0xffe00000, QS_OK},         {"best", 4, 0xffdfffff, QS_E_CORRUPT},
            {"best", 4, 0x001fffff, QS_OK},         {"best", 4, 0x00200000, QS_E_CORRUPT},
            {"best", 8, 0, QS_E_CORRUPT},           {"best", 8, 2, QS_E_CORRUPT},
            {"best", 8, 4, QS_E_CORRUPT},           {"best", 12, 1, QS_E_CORRUPT},
            {"best", 16, 0x02010102, QS_OK},        {"best", 16, 0x00000003, QS_E_CORRUPT},
            {"best", 16, 0x00000200, QS_E_CORRUPT}, {"best", 16, 0x00020000, QS_E_CORRUPT},
            {"best", 16, 0x03000000, QS_E_CORRUPT}, {"best", 16, 0xff000000, QS_E_CORRUPT},
        };
        expect_breaches(reduced.file, reduced.size, breaches, sizeof breaches / sizeof *breaches,
                        open_qubo);
    }
}

/* The file with another payload of a chunk. */
static qs_status open_replaced(const char *type, const uint8_t *bytes, size_t length)
{
    uint8_t file[TINY_FILE];
    size_t at = payload(reduced.file, reduced.size, type),
           after = at + (size_t)qs_load_u64(reduced.file + at - 8) + 4;
    memcpy(file, reduced.file, at);
    qs_store_u64(file + at - 8, length);
    memcpy(file + at, bytes, length);
    memcpy(file + at + length + 4, reduced.file + after, reduced.size - after);
    size_t size = at + length + 4 + reduced.size - after;
    qs_store_u64(file + 16, size);
    seal(file, size);
    return open_qubo(file, size);
}

static void label_sets_of_other_lengths(void **unused)
{
    (void)unused;
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        write_reduced(encoding, false);
        /* One more fixed site, of which the grid has no cell; and what the file has. */
        static const uint8_t six[] = {6, 0, 0, 0, 1, 0, 0, 0, 255, 2, 255, 255, 255, 1, 7, 5, 6, 7};
        static const uint8_t five[] = {5, 0,   0,   0,   1, 0, 0, 0, 255,
                                       2, 255, 255, 255, 7, 5, 6, 7, 0};
        assert_int_equal(open_replaced("kept", six, 18), QS_E_CORRUPT);
        assert_int_equal(open_replaced("kept", five, 17), QS_OK);
        assert_int_equal(open_replaced("kept", five, 18), QS_E_CORRUPT);
        assert_int_equal(open_replaced("kept", five, 16), QS_E_CORRUPT);
        assert_int_equal(open_replaced("kept", five, 7), QS_E_CORRUPT);
        /* Ten labels left in widths that there are and that there are not. */
        for (uint8_t width = 0; width <= 9; width++) {
            uint8_t cut[8 + 9 * 10 + 1] = {width};
            bool known = width == 1 || width == 2 || width == 4;
            assert_int_equal(open_replaced("trnc", cut, 8 + (size_t)width * 10),
                             known ? QS_OK : QS_E_CORRUPT);
            assert_int_equal(open_replaced("trnc", cut, 8 + (size_t)width * 10 + 1), QS_E_CORRUPT);
        }
        assert_int_equal(open_replaced("trnc", six, 7), QS_E_CORRUPT);
    }
}

static void best_of_other_lengths(void **unused)
{
    (void)unused;
    static const uint8_t four[16 + 5] = {[8] = 1};
    static const uint8_t wide[16 + 8] = {[8] = 2};
    static const uint8_t no_bound[16 + 4] = {[7] = 128, [8] = 1};
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_DOMAIN_WALL; encoding++) {
        write_reduced(encoding, false);
        assert_int_equal(open_replaced("best", four, 20), QS_OK);
        assert_int_equal(open_replaced("best", four, 19), QS_E_CORRUPT);
        assert_int_equal(open_replaced("best", four, 21), QS_E_CORRUPT);
        assert_int_equal(open_replaced("best", four, 15), QS_E_CORRUPT);
        assert_int_equal(open_replaced("best", wide, 24), QS_E_CORRUPT);
        assert_int_equal(open_replaced("best", no_bound, 20), QS_OK);
    }
}

/* A graph may have any number of sites that are fixed, but open ones have groups: else it would
 * take four billion steps to find out. */
static void open_sites_beyond_the_groups(void **unused)
{
    (void)unused;
    for (qs_encoding encoding = QS_DOMAIN_WALL; encoding <= QS_ST_CUT_ARCS; encoding++) {
        static const uint8_t many[] = {255, 255, 255, 255, 0, 0, 0, 0};
        write_reduced(encoding, true);
        size_t at = payload(reduced.file, reduced.size, "labl");
        qs_store_u32(reduced.file + at + 32, 0);
        qs_store_u32(reduced.file + at + 36, 0);
        assert_int_equal(open_replaced("kept", many, 8), QS_E_CORRUPT);
    }
}

/* Where kept says how many sites there are, a mask without a grid would have no bytes at all. */
static void masks_without_a_grid(void **unused)
{
    (void)unused;
    for (uint32_t masked = 0; masked < 2; masked++) {
        uint8_t labl[64];
        write_reduced(QS_ONE_HOT, false);
        memcpy(labl, reduced.file + payload(reduced.file, reduced.size, "labl"), sizeof labl);
        memset(labl + 32, 0, 24);
        qs_store_u32(labl + 60, masked);
        assert_int_equal(open_replaced("labl", labl, sizeof labl), masked ? QS_E_CORRUPT : QS_OK);
    }
}

/* Groups and sets that agree on a site of one label, which must be fixed. */
static void open_sites_have_two_labels(void **unused)
{
    (void)unused;
    tiny t;
    sample_problem(&t);
    slow_request request = {.problem = &t.problem, .encoding = QS_ONE_HOT, .gap = 1};
    memset(request.kept, 1, sizeof request.kept);
    for (uint32_t single = 0; single < 2; single++) {
        request.kept[1][0] = false;
        request.kept[1][1] = single == 0;
        request.open_single = single != 0;
        slow_write(&request, &reduced);
        assert_int_equal(open_qubo(reduced.file, reduced.size), single == 0 ? QS_OK : QS_E_CORRUPT);
    }
}

/* The side chunks of the file in another order, some left out, some twice. */
static qs_status open_with(const char *const *types, size_t count)
{
    uint8_t file[TINY_FILE];
    size_t size = payload(reduced.file, reduced.size, "labl") - 16;
    memcpy(file, reduced.file, size);
    for (size_t i = 0; i < count; i++) {
        const uint8_t *chunk = reduced.file + payload(reduced.file, reduced.size, types[i]) - 16;
        size_t bytes = 20 + (size_t)qs_load_u64(chunk + 8);
        memcpy(file + size, chunk, bytes);
        size += bytes;
    }
    qs_store_u32(file + 12, (uint32_t)(6 + count));
    qs_store_u64(file + 16, size);
    seal(file, size);
    return open_qubo(file, size);
}

static void side_chunks_in_order(void **unused)
{
    (void)unused;
    static const struct {
        const char *types[4];
        size_t count;
        qs_status status;
    } cases[] = {
        {{"labl", "kept", "trnc"}, 3, QS_OK},
        {{"labl", "kept"}, 2, QS_OK},
        {{"labl"}, 0, QS_OK},
        {{"labl"}, 1, QS_E_CORRUPT},
        {{"kept"}, 1, QS_E_CORRUPT},
        {{"trnc"}, 1, QS_E_CORRUPT},
        {{"labl", "trnc"}, 2, QS_E_CORRUPT},
        {{"kept", "trnc"}, 2, QS_E_CORRUPT},
        {{"labl", "trnc", "kept"}, 3, QS_E_CORRUPT},
        {{"kept", "labl", "trnc"}, 3, QS_E_CORRUPT},
        {{"trnc", "labl", "kept"}, 3, QS_E_CORRUPT},
        {{"labl", "kept", "kept"}, 3, QS_E_CORRUPT},
        {{"labl", "kept", "trnc", "trnc"}, 4, QS_E_CORRUPT},
        {{"labl", "kept", "trnc", "kept"}, 4, QS_E_CORRUPT},
        {{"labl", "labl", "kept", "trnc"}, 4, QS_E_CORRUPT},
        {{"labl", "kept", "labl", "trnc"}, 4, QS_E_CORRUPT},
    };
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        write_reduced(encoding, false);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            assert_int_equal(open_with(cases[i].types, cases[i].count), cases[i].status);
        }
    }
    static const struct {
        const char *types[4];
        size_t count;
        qs_status status;
    } with_best[] = {
        {{"labl", "kept", "trnc", "best"}, 4, QS_OK},
        {{"labl", "kept", "best"}, 3, QS_OK},
        {{"best"}, 1, QS_E_CORRUPT},
        {{"labl", "best", "kept"}, 3, QS_E_CORRUPT},
        {{"best", "labl", "kept"}, 3, QS_E_CORRUPT},
        {{"labl", "kept", "best", "trnc"}, 4, QS_E_CORRUPT},
        {{"labl", "kept", "best", "best"}, 4, QS_E_CORRUPT},
    };
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_DOMAIN_WALL; encoding++) {
        write_reduced(encoding, false);
        for (size_t i = 0; i < sizeof with_best / sizeof *with_best; i++) {
            assert_int_equal(open_with(with_best[i].types, with_best[i].count),
                             with_best[i].status);
        }
    }
    /* With all labels left `kept` may be missing in the one-hot encodings alone; all others have
     * it, with nothing in it, and trnc has all labels then. */
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        write_reduced(encoding, true);
        const char *const bare[] = {"labl"}, *const both[] = {"labl", "trnc"},
                          *const late[] = {"labl", "trnc", "kept"};
        assert_int_equal(open_with(bare, 1), encoding <= QS_ONE_HOT_SPARSE ? QS_OK : QS_E_CORRUPT);
        assert_int_equal(open_with(both, 2), encoding <= QS_ONE_HOT_SPARSE ? QS_OK : QS_E_CORRUPT);
        if (encoding > QS_ONE_HOT_SPARSE) {
            assert_int_equal(open_with(late, 3), QS_E_CORRUPT);
            const breach breaches[] = {{"kept", 4, 1, QS_E_CORRUPT},
                                       {"kept", 0, 4, QS_E_CORRUPT},
                                       {"kept", 0, 6, QS_E_CORRUPT}};
            expect_breaches(reduced.file, reduced.size, breaches, 3, open_qubo);
        }
    }
}

/* The groups of one encoding are not those of another, but for the two one-hot ones, and a cut's is
 * one of arcs that has none. */
static void groups_are_those_of_the_encoding(void **unused)
{
    (void)unused;
    for (uint32_t encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        write_reduced((qs_encoding)encoding, false);
        for (uint32_t said = QS_ONE_HOT; said <= QS_ST_CUT_ARCS; said++) {
            bool fits = encoding == said ||
                        (encoding <= QS_ONE_HOT_SPARSE && said <= QS_ONE_HOT_SPARSE) ||
                        (encoding == QS_ST_CUT && said == QS_ST_CUT_ARCS);
            const breach as = {"labl", 0, said, fits ? QS_OK : QS_E_CORRUPT};
            expect_breaches(reduced.file, reduced.size, &as, 1, open_qubo);
        }
    }
}

/* A group without a penalty is not one-hot, and so no site or terminal of the encodings whose sites
 * are. One number of the two is enough. */
static void sites_have_penalties(void **unused)
{
    (void)unused;
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        write_reduced(encoding, false);
        uint32_t groups = reduced.qubo.groups;
        bool one_hot = encoding <= QS_ONE_HOT_SPARSE || encoding == QS_MULTIWAY_CUT;
        for (uint8_t pair = 0; pair < 4 && encoding != QS_DOMAIN_WALL;
             pair++) { /* chains are no groups with a penalty */
            uint8_t a = pair & 1, b = pair >> 1;
            const uint8_t all[] = {1, 0, 0, 0, 0, 0, 0, 0, (uint8_t)groups, 0, 0, 0, a, b};
            const uint8_t last[] = {1, 0, 0, 0, 0, 0, 0, 0, (uint8_t)(groups - 1), 0, 0, 0,
                                    7, 9, 1, 0, 0, 0, a, b};
            assert_int_equal(open_replaced("PNLT", all, sizeof all),
                             one_hot && pair == 0 ? QS_E_CORRUPT : QS_OK);
            assert_int_equal(open_replaced("PNLT", last, sizeof last),
                             one_hot && pair == 0 ? QS_E_CORRUPT : QS_OK);
        }
    }
}

/* More than 255 labels: two bytes for a fixed one. Nothing is left to decide, so that there are no
 * variables. */
static void wide_fixed_labels(void **unused)
{
    (void)unused;
    write_reduced(QS_DOMAIN_WALL, false);
    for (uint32_t width = 1; width <= 2; width++) {
        uint8_t file[1024] = {0};
        static const char *const heads[] = {"GRPS", "BLKS", "CPLS", "LINR",
                                            "PNLT", "OFFS", "labl", "kept"};
        const size_t sizes[] = {0, 4, 4, 16, 8, 8, 64, 8 + width * 5};
        size_t at = HEADER;
        memcpy(file, reduced.file, 12);
        for (int i = 0; i < 8; i++) {
            memcpy(file + at, heads[i], 4);
            file[at + 8] = (uint8_t)sizes[i];
            uint8_t *data = file + at + 16;
            if (i == 3) {
                data[8] = 1;
            } else if (i == 4) {
                data[0] = 1;
            } else if (i == 6) {
                memcpy(data, reduced.file + payload(reduced.file, reduced.size, "labl"), 64);
                qs_store_u32(data + 12, 300);
                memset(data + 32, 0, 32);
            } else if (i == 7) {
                data[0] = 5;
                data[4] = (uint8_t)width;
            }
            at += 20 + sizes[i];
        }
        qs_store_u32(file + 12, 8);
        qs_store_u64(file + 16, at);
        seal(file, at);
        assert_int_equal(open_qubo(file, at), width == 2 ? QS_OK : QS_E_CORRUPT);
        if (width == 2) {
            const breach breaches[] = {{"kept", 8, 299, QS_OK},
                                       {"kept", 8, 300, QS_E_CORRUPT},
                                       {"kept", 8, 0xffff, QS_E_CORRUPT},
                                       {"labl", 12, 65535, QS_OK},
                                       {"labl", 12, 65536, QS_E_CORRUPT}};
            expect_breaches(file, at, breaches, 5, open_qubo);
        }
    }
}

static void memory_limit(void **unused)
{
    (void)unused;
    tiny t;
    qs_qubo qubo;
    qs_fault fault = {0};
    sample_problem(&t);
    tiny_encode(&t.problem, (qs_encode_options){QS_ONE_HOT, QS_PENALTY_LOCAL, 0, 3}, &q);
    size_t needed = qs_index_workspace(&q.qubo);
    assert_int_equal(qs_qubo_open(q.file, q.size, needed, &qubo, &fault), QS_OK);
    assert_int_equal(qs_index_build(&qubo, q.memory, needed - 1, &q.index), QS_E_WORKSPACE);
    memset(&qubo, 0x55, sizeof qubo);
    assert_int_equal(qs_qubo_open(q.file, q.size, needed - 1, &qubo, &fault), QS_E_LIMIT);
    assert_int_equal(qs_index_workspace(&qubo), needed); /* so a caller can say it */
    /* The header's counts decide before the rest is looked at. */
    q.file[HEADER + 3] ^= 1;
    assert_int_equal(qs_qubo_open(q.file, q.size, 100, &qubo, &fault), QS_E_LIMIT);
    assert_int_equal(fault.offset, 24);
    assert_int_not_equal(qs_index_workspace(&qubo), needed);
}

static const qs_record records[3] = {{-5, 1, QS_NO_CHAINS}, {INT64_MAX, 7, 0}, {0, 2, 1000000000}};
static const uint8_t bits[3][2] = {{0xff, 0x07}, {0x01, 0x02}, {0x00, 0x00}};

static qs_samples some_samples(void)
{
    qs_samples samples = {.variables = 11,
                          .count = 3,
                          .solver = "exact",
                          .solver_size = 5,
                          .info = "{\"a\": 1}",
                          .info_size = 8,
                          .records = records,
                          .bits = bits[0]};
    memset(samples.problem, 0xab, sizeof samples.problem);
    return samples;
}

static size_t write_samples(const qs_samples *samples, uint8_t *file)
{
    qs_buffer buffer = {file, TINY_FILE, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    uint64_t size, counted;
    assert_int_equal(qs_samples_write(samples, &sink, &size), QS_OK);
    assert_int_equal(qs_samples_write(samples, NULL, &counted), QS_OK);
    assert_int_equal(size, buffer.size);
    assert_int_equal(size, counted);
    return buffer.size;
}

static void samples_round_trip(void **unused)
{
    (void)unused;
    uint8_t file[TINY_FILE];
    qs_samples samples = some_samples();
    size_t size = write_samples(&samples, file);
    qs_samples_view view;
    assert_int_equal(qs_samples_open(file, size, &view, NULL), QS_OK);
    assert_int_equal(view.variables, 11);
    assert_int_equal(view.count, 3);
    assert_memory_equal(view.problem, samples.problem, QS_DIGEST_SIZE);
    assert_int_equal(view.solver_size, 5);
    assert_memory_equal(view.solver, "exact", 5);
    assert_memory_equal(view.info, "{\"a\": 1}", 8);
    for (uint32_t i = 0; i < 3; i++) {
        qs_record record = qs_samples_record(&view, i);
        assert_int_equal(record.energy, records[i].energy);
        assert_int_equal(record.occurrences, records[i].occurrences);
        assert_int_equal(record.chain_breaks, records[i].chain_breaks);
        assert_memory_equal(qs_samples_bits(&view, i), bits[i], 2);
    }
    truncations(file, size, open_samples);
    flips(file, size, open_samples);
}

static void no_samples(void **unused)
{
    (void)unused;
    uint8_t file[TINY_FILE];
    qs_samples samples = some_samples();
    samples.count = 0;
    samples.records = NULL;
    samples.bits = NULL;
    size_t size = write_samples(&samples, file);
    assert_int_equal(open_samples(file, size), QS_OK);
}

static void broken_samples(void **unused)
{
    (void)unused;
    uint8_t file[TINY_FILE];
    qs_samples samples = some_samples();
    size_t size = write_samples(&samples, file);
    const breach breaches[] = {
        {NULL, 8, 2, QS_E_UNSUPPORTED},
        {NULL, 24, 0, QS_E_CORRUPT},
        {NULL, 24, 17, QS_E_CORRUPT},
        {NULL, 28, 2, QS_E_CORRUPT},
        {NULL, 28, 4, QS_E_CORRUPT},
        {NULL, 32, 1, QS_E_CORRUPT},
        {"SOLV", 0, 7, QS_E_CORRUPT},
        {"INFO", 0, '[', QS_E_CORRUPT},
        {"SOLV", 0, 0x61617865u + 0x80, QS_E_CORRUPT},
        {"INFO", 2, 0xff222261, QS_E_CORRUPT},
        {"RECS", 8, 0, QS_E_CORRUPT},
        {"RECS", 12, 1000000001, QS_E_CORRUPT},
        {"BITS", 0, 0xffff, QS_E_CORRUPT},
    };
    expect_breaches(file, size, breaches, sizeof breaches / sizeof *breaches, open_samples);
}

static void samples_refused_by_the_writer(void **unused)
{
    (void)unused;
    qs_samples samples = some_samples();
    samples.solver_size = 0;
    assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_E_ARGUMENT);
    samples = some_samples();
    samples.solver = "exa\nt";
    assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_E_ARGUMENT);
    samples = some_samples();
    samples.info_size = 7;
    assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_E_ARGUMENT);
    samples = some_samples();
    samples.variables = 10; /* sample 0 has bit 10 set */
    assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_E_ARGUMENT);
    samples = some_samples();
    const qs_record wrong[3] = {{0, 0, 0}, {0, 1, 0}, {0, 1, 0}};
    samples.records = wrong;
    assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_E_ARGUMENT);
}

/* RFC 3629: shortest forms only, no surrogates, nothing beyond U+10FFFF, nothing cut off; no
 * control characters in a name. */
static void names_are_utf8(void **unused)
{
    (void)unused;
    static const char *const good[] = {"a",
                                       "\xc3\xa9",
                                       "\xe2\x82\xac",
                                       "\xf0\x9f\x98\x80",
                                       "\xed\x9f\xbf",
                                       "\xf4\x8f\xbf\xbf",
                                       "\xc2\xa0"};
    static const char *const bad[] = {"\xff",         "\xc3",
                                      "\xe2\x82",     "\xc0\x80",
                                      "\xe0\x80\x80", "\xf0\x80\x80\x80",
                                      "\xed\xa0\x80", "\xf4\x90\x80\x80",
                                      "\x80",         "a\x07",
                                      "\x7f",         "\xc2\x85",
                                      "\xc3("};
    qs_samples samples = some_samples();
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        samples.solver = good[i];
        samples.solver_size = strlen(good[i]);
        assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_OK);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        samples.solver = bad[i];
        samples.solver_size = strlen(bad[i]);
        assert_int_equal(qs_samples_write(&samples, NULL, NULL), QS_E_ARGUMENT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(sizing_pass_tells_the_size),
        cmocka_unit_test(damaged_qubos),
        cmocka_unit_test(broken_promises),
        cmocka_unit_test(fields_beside_others),
        cmocka_unit_test(grids_alone_have_masks_and_pictures),
        cmocka_unit_test(masks_without_a_grid),
        cmocka_unit_test(lattices_name_a_pair_once),
        cmocka_unit_test(meanings),
        cmocka_unit_test(strange_chunks),
        cmocka_unit_test(broken_label_sets),
        cmocka_unit_test(label_sets_of_other_lengths),
        cmocka_unit_test(broken_best),
        cmocka_unit_test(best_of_other_lengths),
        cmocka_unit_test(open_sites_beyond_the_groups),
        cmocka_unit_test(open_sites_have_two_labels),
        cmocka_unit_test(side_chunks_in_order),
        cmocka_unit_test(groups_are_those_of_the_encoding),
        cmocka_unit_test(sites_have_penalties),
        cmocka_unit_test(wide_fixed_labels),
        cmocka_unit_test(memory_limit),
        cmocka_unit_test(samples_round_trip),
        cmocka_unit_test(no_samples),
        cmocka_unit_test(broken_samples),
        cmocka_unit_test(samples_refused_by_the_writer),
        cmocka_unit_test(names_are_utf8),
    };
    return cmocka_run_group_tests_name("files", tests, NULL, NULL);
}
