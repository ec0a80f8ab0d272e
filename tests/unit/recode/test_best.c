/* The labelling and the bound that a file carries, written and read back. */
#include "recoded.h"

enum { BOUND = -123456789 };

/* A labelling of labels left, of the problem's sites. */
static void draw_labelling(const fixture *f, uint64_t *state, uint16_t *labelling)
{
    for (uint32_t p = 0; p < f->sites; p++) {
        labelling[p] = (uint16_t)nth_label(f, p, tiny_random(state, count_labels(f, p)));
    }
}

/* The file of the fixture once more, with `best` in it. */
static qs_status write_best(fixture *f, qs_encoding encoding, bool truncate, const uint16_t *best,
                            uint8_t file[MEMORY], size_t *size)
{
    qs_recode_options options = {.encode.encoding = encoding,
                                 .truncate = truncate,
                                 .kept = f->kept,
                                 .best = best,
                                 .lower_bound = BOUND};
    qs_buffer buffer = {file, MEMORY, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    size_t room = qs_recode_workspace(&f->model, &options);
    void *workspace = malloc(room + !room);
    uint64_t told = 0;
    qs_status status =
        qs_recode(&f->model, &f->source_qubo.labels, &options, &sink, workspace, room, &told);
    free(workspace);
    *size = buffer.size;
    assert_int_equal(told, status == QS_OK ? buffer.size : 0);
    return status;
}

/* The state in the file is the one of the labelling. */
static void check_state(const uint8_t *file, size_t size, const uint16_t *best, uint32_t sites)
{
    static uint64_t memory[MEMORY / 8];
    uint8_t expected[BYTES], found[BYTES];
    uint16_t decoded[TINY_SITES];
    qs_qubo qubo;
    qs_index index;
    open_file(file, size, &qubo, memory, &index);
    assert_int_equal(qubo.known.bytes, 1);
    assert_int_equal(qubo.known.lower_bound, BOUND);
    assert_int_equal(qs_sample_encode(&index, best, expected), QS_OK);
    memset(found, 0xff, sizeof found);
    qs_qubo_known_state(&qubo, found);
    assert_memory_equal(found, expected, (qubo.variables + 7) / 8);
    assert_int_equal(qs_sample_decode(&index, found, decoded), QS_OK);
    assert_memory_equal(decoded, best, sites * sizeof *best);
}

static void best_is_read_back(void **unused)
{
    (void)unused;
    static fixture f;
    static uint8_t file[MEMORY];
    uint64_t state = 71;
    uint32_t seen = 0;
    for (int round = 0; round < 3 * ROUNDS; round++) {
        qs_encoding encoding = (qs_encoding)(QS_ONE_HOT + round % 3);
        uint16_t best[TINY_SITES];
        size_t size;
        bool truncate = tiny_random(&state, 2) == 0;
        (void)random_file(&f, &state, SOURCE_BITS, potts,
                          (qs_encode_options){.encoding = encoding});
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = encoding}, truncate), QS_OK);
        draw_labelling(&f, &state, best);
        assert_int_equal(write_best(&f, encoding, truncate, best, file, &size), QS_OK);
        if (f.qubo.variables == 0) {
            assert_int_equal(size, f.size);
            assert_memory_equal(file, f.file, size);
            continue;
        }
        /* One chunk more: all else behind the header is the same. */
        assert_int_equal(size, f.size + 20 + 16 + f.qubo.groups);
        assert_memory_equal(file + 64, f.file + 64, f.size - 64);
        check_state(file, size, best, f.sites);
        seen++;
    }
    assert_true(seen > ROUNDS);
}

/* Cuts have no such chunk. */
static void cuts_carry_none(void **unused)
{
    (void)unused;
    static fixture f;
    static uint8_t file[MEMORY];
    for (qs_encoding encoding = QS_MULTIWAY_CUT; encoding <= QS_ST_CUT_ARCS; encoding++) {
        uint16_t best[TINY_SITES] = {0};
        size_t size;
        make_grid(&f, 2, 2, 2, 5, QS_POTTS);
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = encoding}, false), QS_OK);
        assert_int_equal(write_best(&f, encoding, false, best, file, &size), QS_OK);
        assert_int_equal(size, f.size);
        assert_memory_equal(file, f.file, size);
    }
}

/* A label that has left, of an undecided site and of a fixed one. */
static void labels_that_have_left(void **unused)
{
    (void)unused;
    static fixture f;
    static uint8_t file[MEMORY];
    make_grid(&f, 3, 1, 3, 5, QS_POTTS);
    f.left[0] = 5;
    f.left[1] = 2;
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_DOMAIN_WALL; encoding++) {
        size_t size;
        assert_int_equal(recode(&f, (qs_encode_options){.encoding = encoding}, false), QS_OK);
        assert_int_equal(write_best(&f, encoding, false, (uint16_t[]){2, 1, 0}, file, &size),
                         QS_OK);
        check_state(file, size, (uint16_t[]){2, 1, 0}, 3);
        static const uint16_t wrong[][3] = {{1, 1, 0}, {2, 0, 0}, {2, 2, 0}, {2, 1, 3}};
        for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
            assert_int_equal(write_best(&f, encoding, false, wrong[i], file, &size), QS_E_ARGUMENT);
            assert_int_equal(size, 0);
        }
    }
}

/* Above 255 labels a number takes two bytes, and the last label of a wall is none of its
 * variables. */
static void many_labels(void **unused)
{
    (void)unused;
    enum { LABELS = 300, SITES = 2 };
    static int32_t costs[SITES * LABELS];
    static uint8_t source[MEMORY], file[MEMORY];
    static uint64_t index_memory[MEMORY / 8], model_memory[MEMORY / 8], memory[MEMORY / 8];
    const qs_problem problem = {.labels = LABELS,
                                .scale = 1,
                                .weight = 1,
                                .grid = {.width = SITES, .height = 1},
                                .costs = costs};
    qs_buffer buffer = {source, sizeof source, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    qs_qubo qubo;
    qs_index index;
    qs_model model;
    assert_int_equal(
        qs_encode(&problem, &(qs_encode_options){0}, &sink, memory, sizeof memory, NULL), QS_OK);
    open_file(source, buffer.size, &qubo, index_memory, &index);
    assert_int_equal(qs_model_build(&index, model_memory, sizeof model_memory, &model), QS_OK);
    for (qs_encoding encoding = QS_ONE_HOT; encoding <= QS_DOMAIN_WALL; encoding++) {
        const uint16_t best[SITES] = {LABELS - 1, 256};
        const qs_recode_options options = {
            .encode.encoding = encoding, .best = best, .lower_bound = QS_NO_BOUND};
        uint8_t bits[2 * LABELS / 8 + 1];
        uint16_t decoded[SITES];
        qs_qubo again;
        qs_index again_index;
        static uint64_t again_memory[MEMORY / 8];
        buffer = (qs_buffer){file, sizeof file, 0};
        assert_true(qs_recode_workspace(&model, &options) <= sizeof memory);
        assert_int_equal(
            qs_recode(&model, &qubo.labels, &options, &sink, memory, sizeof memory, NULL), QS_OK);
        open_file(file, buffer.size, &again, again_memory, &again_index);
        assert_int_equal(again.known.bytes, 2);
        assert_true(again.known.lower_bound == QS_NO_BOUND);
        qs_qubo_known_state(&again, bits);
        assert_int_equal(qs_sample_decode(&again_index, bits, decoded), QS_OK);
        assert_memory_equal(decoded, best, sizeof best);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(best_is_read_back),
        cmocka_unit_test(cuts_carry_none),
        cmocka_unit_test(labels_that_have_left),
        cmocka_unit_test(many_labels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
