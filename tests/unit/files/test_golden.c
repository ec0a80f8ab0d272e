/* The golden files: one canonical string of bytes for each of a few problems that between them use
 * the whole format.
 *
 *     QSTEREO_WRITE_GOLDEN=1 build/unit/files/test_golden
 *
 * writes them again; then see with git what has changed, and why. */
#include "tiny.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static tiny_qubo q;
static tiny t;

static void costs(int32_t first, int32_t step, int32_t modulus)
{
    for (int i = 0; i < TINY_SITES * TINY_LABELS; i++) {
        t.costs[i] = first + i * step % modulus;
    }
}

static void base(uint32_t labels, uint32_t width, uint32_t height, int32_t weight)
{
    memset(&t, 0, sizeof t);
    t.problem = (qs_problem){.labels = labels,
                             .scale = 1,
                             .weight = weight,
                             .grid = {.width = width, .height = height},
                             .costs = t.costs};
}

/* Two sites, two labels: the worked example of docs/FORMAT.md. */
static qs_encode_options smallest(void)
{
    base(2, 2, 1, 3);
    memcpy(t.costs, (int32_t[]){5, 7, 4, 4}, 4 * sizeof(int32_t));
    return (qs_encode_options){0};
}

static qs_encode_options grid_sparse(void)
{
    base(3, 4, 3, 20);
    costs(0, 37, 101);
    t.problem.frame = (qs_frame){9, 5, 3, 1, 2};
    return (qs_encode_options){.gap = 2};
}

static qs_encode_options grid_paper(void)
{
    base(3, 3, 3, 12);
    costs(0, 37, 101);
    return (qs_encode_options){QS_ONE_HOT, QS_PENALTY_PAPER, 0, 0};
}

static qs_encode_options masked_weighted(void)
{
    base(2, 4, 3, 0);
    costs(-300, 411, 997);
    for (int i = 0; i < 12; i++) {
        t.mask[i] = i != 5 && i != 2;
        t.right[i] = i;
        t.down[i] = 40 * i;
    }
    t.problem.grid.mask = t.mask;
    t.problem.grid.right = t.right;
    t.problem.grid.down = t.down;
    return (qs_encode_options){0};
}

static qs_encode_options linear(void)
{
    base(5, 3, 2, 4);
    costs(0, 70001, 900001);
    t.problem.scale = 2;
    t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_LINEAR, 3, NULL};
    return (qs_encode_options){0};
}

/* Disparities -2 to 1, in a window whose right border is left out of its picture. */
static qs_encode_options negative(void)
{
    base(4, 3, 2, 9);
    costs(0, 37, 101);
    t.problem.frame = (qs_frame){6, 2, 1, 0, -2};
    return (qs_encode_options){.encoding = QS_ONE_HOT_SPARSE};
}

static qs_encode_options quadratic(void)
{
    base(4, 2, 2, 1);
    costs(0, 13, 41);
    t.problem.pairwise = (qs_pairwise){QS_TRUNCATED_QUADRATIC, 0, NULL};
    return (qs_encode_options){QS_ONE_HOT, QS_PENALTY_GIVEN, 1000, 0};
}

static qs_encode_options edges_table(void)
{
    base(3, 0, 0, 0);
    costs(-9, 5, 23);
    t.problem.sites = 4;
    memcpy(t.table, (int32_t[]){0, 2, 5, 1, 0, 3, 9, 4, 0}, 9 * sizeof(int32_t));
    t.problem.pairwise = (qs_pairwise){QS_TABLE, 0, t.table};
    memcpy(t.edges, (qs_edge[]){{0, 1, 2}, {1, 3, 200}, {0, 3, 0}, {2, 3, 1}}, 4 * sizeof(qs_edge));
    t.problem.edges = t.edges;
    t.problem.edge_count = 4;
    return (qs_encode_options){0};
}

static const struct {
    const char *name;
    qs_encode_options (*make)(void);
} golden[] = {
    {"good-smallest", smallest},       {"good-grid-sparse", grid_sparse},
    {"good-grid-paper", grid_paper},   {"good-masked-weighted", masked_weighted},
    {"good-linear", linear},           {"good-quadratic", quadratic},
    {"good-edges-table", edges_table}, {"good-negative", negative},
};

/* The same problems written again: the sources stand above. Of the labels left to each site a bit
 * each. */
static const struct {
    const char *name;
    qs_encode_options (*make)(void);
    qs_encode_options write;
    bool truncate;
    uint8_t left[TINY_SITES];
} recoded[] = {
    {"recoded-sparse",
     grid_sparse,
     {.encoding = QS_ONE_HOT_SPARSE, .penalty = QS_PENALTY_MINIMAL},
     true,
     {7, 1, 6, 5, 7, 7, 2, 3, 4, 7, 7, 6}},
    {"recoded-band", linear, {.encoding = QS_ONE_HOT_SPARSE}, false, {31, 31, 25, 31, 31, 7}},
    {"recoded-domain-wall",
     grid_sparse,
     {.encoding = QS_DOMAIN_WALL, .gap = 3},
     false,
     {7, 1, 6, 5, 7, 7, 2, 3, 4, 7, 7, 6}},
    {"recoded-multiway-cut",
     masked_weighted,
     {.encoding = QS_MULTIWAY_CUT},
     false,
     {3, 3, 3, 3, 1, 3, 3, 3, 3, 3}},
    {"recoded-st-cut", smallest, {.encoding = QS_ST_CUT}, false, {3, 3}},
    {"recoded-st-cut-arcs", smallest, {.encoding = QS_ST_CUT_ARCS}, false, {3, 3}},
    {"recoded-nothing",
     grid_sparse,
     {.encoding = QS_DOMAIN_WALL},
     false,
     {1, 1, 4, 2, 1, 1, 1, 2, 4, 1, 1, 1}},
};

/* And one that carries a labelling and a bound. */
static const uint16_t known_best[TINY_SITES] = {0, 0, 1, 2, 2, 0, 1, 1, 2, 0, 1, 2};
enum { KNOWN_BOUND = 200 };

static FILE *open_golden(const char *name, const char *suffix, const char *mode)
{
    char path[256];
    snprintf(path, sizeof path, "tests/golden/%s.%s", name, suffix);
    FILE *file = fopen(path, mode);
    if (!file) {
        fail_msg("cannot open %s: run from the project's root", path);
    }
    return file;
}

static void compare_file(const char *name, const char *suffix, const uint8_t *bytes, size_t size)
{
    if (getenv("QSTEREO_WRITE_GOLDEN")) {
        FILE *file = open_golden(name, suffix, "wb");
        assert_int_equal(fwrite(bytes, 1, size, file), size);
        assert_int_equal(fclose(file), 0);
        return;
    }
    static uint8_t stored[TINY_FILE];
    FILE *file = open_golden(name, suffix, "rb");
    size_t stored_size = fread(stored, 1, sizeof stored, file);
    fclose(file);
    assert_int_equal(stored_size, size);
    assert_memory_equal(stored, bytes, size);
}

/* The samples: all labels 0, all labels 1 and an infeasible state, with true energies. */
static void compare_samples(const char *name)
{
    uint8_t bits[3][16] = {{0}}, packed[3 * 16], file[TINY_FILE];
    size_t each = (q.qubo.variables + 7) / 8;
    qs_record records[3];
    uint16_t labelling[TINY_SITES] = {0};
    assert_int_equal(qs_sample_encode(&q.index, labelling, bits[0]), QS_OK);
    for (int p = 0; p < TINY_SITES; p++) {
        labelling[p] = 1;
    }
    assert_int_equal(qs_sample_encode(&q.index, labelling, bits[1]), QS_OK);
    bits[2][0] = 3;
    for (uint32_t i = 0; i < 3; i++) {
        memcpy(packed + i * each, bits[i], each);
        records[i] = (qs_record){qs_qubo_energy(&q.index, bits[i]), i + 1,
                                 i == 0 ? QS_NO_CHAINS : i * 250000000};
    }
    static const char info[] = "{\"by\": \"hand\"}";
    qs_samples samples = {.variables = q.qubo.variables,
                          .count = 3,
                          .solver = "golden",
                          .solver_size = 6,
                          .info = info,
                          .info_size = sizeof info - 1,
                          .records = records,
                          .bits = packed};
    qs_digest(q.file, q.size, samples.problem);
    qs_buffer buffer = {file, sizeof file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_int_equal(qs_samples_write(&samples, &sink, NULL), QS_OK);
    compare_file(name, "qsf", file, buffer.size);
}

static void golden_files(void **unused)
{
    (void)unused;
    for (size_t i = 0; i < sizeof golden / sizeof *golden; i++) {
        qs_encode_options options = golden[i].make();
        tiny_encode(&t.problem, options, &q);
        compare_file(golden[i].name, "qcf", q.file, q.size);
        compare_samples(golden[i].name);
    }
}

/* Replaces the file of `q` by one of the labels left.
 *
 * best  that the file carries; NULL = none */
static void recode(qs_encode_options write, bool truncate, const uint8_t *left,
                   const uint16_t *best)
{
    static uint64_t model_memory[1024], memory[8192];
    static uint8_t file[TINY_FILE];
    uint8_t kept[TINY_SITES * TINY_LABELS] = {0};
    qs_model model;
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model), QS_OK);
    for (uint32_t cell = 0, site = 0; cell < model.sites; cell++) {
        bool masked = t.problem.grid.mask && t.problem.grid.mask[cell] == 0;
        for (uint32_t d = 0; d < model.labels; d++) {
            kept[cell * model.labels + d] = masked ? d == 0 : left[site] >> d & 1;
        }
        site += !masked;
    }
    qs_recode_options options = {.encode = write,
                                 .truncate = truncate,
                                 .kept = kept,
                                 .best = best,
                                 .lower_bound = KNOWN_BOUND};
    qs_buffer buffer = {file, sizeof file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_true(qs_recode_workspace(&model, &options) <= sizeof memory);
    assert_int_equal(
        qs_recode(&model, &q.qubo.labels, &options, &sink, memory, sizeof memory, NULL), QS_OK);
    memcpy(q.file, file, buffer.size);
    q.size = buffer.size;
    assert_int_equal(qs_qubo_open(q.file, q.size, TINY_INDEX, &q.qubo, NULL), QS_OK);
    assert_int_equal(qs_index_build(&q.qubo, q.memory, sizeof q.memory, &q.index), QS_OK);
}

/* The samples: each site's lowest label that is left, then every variable at 0 and at 1. */
static void compare_states(const char *name, const uint8_t *left)
{
    uint8_t bits[3][16] = {{0}}, packed[3 * 16], file[TINY_FILE];
    size_t each = (q.qubo.variables + 7) / 8;
    qs_record records[3];
    uint16_t labelling[TINY_SITES] = {0};
    for (uint32_t p = 0; p < q.qubo.labels.sites; p++) {
        while ((left[p] >> labelling[p] & 1) == 0) {
            labelling[p]++;
        }
    }
    assert_int_equal(qs_sample_encode(&q.index, labelling, bits[0]), QS_OK);
    for (uint32_t i = 0; i < q.qubo.variables; i++) {
        bits[2][i / 8] |= (uint8_t)(1 << i % 8);
    }
    for (uint32_t i = 0; i < 3; i++) {
        memcpy(packed + i * each, bits[i], each);
        records[i] = (qs_record){qs_qubo_energy(&q.index, bits[i]), 1, QS_NO_CHAINS};
    }
    qs_samples samples = {.variables = q.qubo.variables,
                          .count = 3,
                          .solver = "golden",
                          .solver_size = 6,
                          .info = "{}",
                          .info_size = 2,
                          .records = records,
                          .bits = packed};
    qs_digest(q.file, q.size, samples.problem);
    qs_buffer buffer = {file, sizeof file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_int_equal(qs_samples_write(&samples, &sink, NULL), QS_OK);
    compare_file(name, "qsf", file, buffer.size);
}

static void recoded_files(void **unused)
{
    (void)unused;
    for (size_t i = 0; i < sizeof recoded / sizeof *recoded; i++) {
        qs_encode_options options = recoded[i].make();
        tiny_encode(&t.problem, options, &q);
        recode(recoded[i].write, recoded[i].truncate, recoded[i].left, NULL);
        compare_file(recoded[i].name, "qcf", q.file, q.size);
        compare_states(recoded[i].name, recoded[i].left);
    }
}

static void file_with_a_labelling(void **unused)
{
    (void)unused;
    static const uint8_t left[TINY_SITES] = {7, 1, 6, 5, 7, 7, 2, 3, 4, 7, 7, 6};
    qs_encode_options options = grid_sparse();
    tiny_encode(&t.problem, options, &q);
    recode((qs_encode_options){.encoding = QS_DOMAIN_WALL}, true, left, known_best);
    compare_file("recoded-known", "qcf", q.file, q.size);
    compare_states("recoded-known", left);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(golden_files),
                                       cmocka_unit_test(recoded_files),
                                       cmocka_unit_test(file_with_a_labelling)};
    return cmocka_run_group_tests_name("golden", tests, NULL, NULL);
}
