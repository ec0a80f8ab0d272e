/* The model of a file, beside the problem that it was made from. */
#include "modelled.h"

#include <string.h>

/* Random labels of the model's sites; the problem's energy of them is the model's. */
static void model_has_the_problems_energy(void **unused)
{
    (void)unused;
    uint64_t state = 21;
    for (int round = 0; round < 4 * ROUNDS; round++) {
        make_model(&state, round % 2 == 0, round % 4 == 0 ? QS_ONE_HOT : QS_ENCODING_DEFAULT);
        for (int i = 0; i < 5; i++) {
            uint16_t labelling[TINY_SITES], sites[TINY_SITES];
            for (uint32_t p = 0; p < model.sites; p++) {
                labelling[p] = (uint16_t)tiny_random(&state, model.labels);
            }
            qs_model_sites(&model, labelling, sites);
            int64_t energy;
            assert_int_equal(qs_problem_energy(&t.problem, sites, NULL, 0, &energy), QS_OK);
            assert_int_equal(qs_model_energy(&model, labelling), energy);
        }
    }
}

static void links_are_sorted_and_numbered(void **unused)
{
    (void)unused;
    uint64_t state = 22;
    for (int round = 0; round < ROUNDS; round++) {
        make_model(&state, true, QS_ENCODING_DEFAULT);
        if (model.width > 0) {
            continue;
        }
        uint32_t ends[TINY_EDGES][2] = {{0}}, seen[TINY_EDGES] = {0};
        for (uint32_t p = 0; p < model.sites; p++) {
            for (uint32_t n = model.link_start[p]; n < model.link_start[p + 1]; n++) {
                const qs_link *link = &model.links[n];
                assert_true(n == model.link_start[p] || model.links[n - 1].site <= link->site);
                assert_true(link->edge < model.edges);
                uint32_t pair[2] = {p < link->site ? p : link->site,
                                    p < link->site ? link->site : p};
                assert_true(seen[link->edge] == 0 ||
                            memcmp(ends[link->edge], pair, sizeof pair) == 0);
                memcpy(ends[link->edge], pair, sizeof pair);
                seen[link->edge]++;
            }
        }
        for (uint32_t e = 0; e < model.edges; e++) {
            assert_int_equal(seen[e], 2);
        }
    }
}

static void winner_takes_all(void **unused)
{
    (void)unused;
    uint64_t state = 23;
    for (int round = 0; round < ROUNDS; round++) {
        make_model(&state, true, QS_ENCODING_DEFAULT);
        uint16_t labelling[TINY_SITES];
        qs_model_winner(&model, labelling);
        for (uint32_t p = 0; p < model.sites; p++) {
            for (uint32_t d = 0; d < model.labels; d++) {
                int32_t other = model.unary[p * model.labels + d],
                        own = model.unary[p * model.labels + labelling[p]];
                assert_true(d < labelling[p] ? other > own : other >= own);
            }
            assert_int_equal(model.unary[p * model.labels + labelling[p]], 0);
        }
    }
}

/* Files whose couplings are not what their encoding says. */
static void strange_models(void **unused)
{
    (void)unused;
    uint64_t state = 24;
    for (int round = 0; round < ROUNDS; round++) {
        make_model(&state, true, QS_ONE_HOT_SPARSE);
        qs_model unchanged = model;
        if (q.qubo.couplings == 0) {
            continue;
        }
        q.qubo.labels.encoding = QS_ONE_HOT;
        assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                         QS_E_CORRUPT);
        q.qubo.labels.encoding = QS_ONE_HOT_SPARSE;
        q.qubo.labels.pairwise.smoothness = QS_TRUNCATED_LINEAR;
        qs_model linear; /* of two labels it is the same cost */
        assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &linear),
                         model.labels == 2 ? QS_OK : QS_E_CORRUPT);
        q.qubo.labels.pairwise.smoothness = QS_TABLE;
        assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                         QS_E_CORRUPT);
        q.qubo.has_labels = false;
        assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                         QS_E_UNSUPPORTED);
        q.qubo.has_labels = true;
        q.qubo.labels.pairwise.smoothness = QS_POTTS;
        assert_int_equal(
            qs_model_build(&q.index, model_memory, qs_model_workspace(&q.qubo) - 1, &model),
            QS_E_WORKSPACE);
        assert_memory_equal(&model, &unchanged, sizeof model);
        if (model.width > 1 && model.height > 1 && model.width != model.height && !model.mask) {
            q.qubo.labels.width = model.height; /* another shape of the same number of cells */
            q.qubo.labels.height = model.width;
            assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                             QS_E_CORRUPT);
        }
    }
}

/* Labellings of labels that are left have the problem's energies. The other labels are marked in
 * `kept`, and cost more than the edges of their site can. */
static void reduced_models_have_the_problems_energy(void **unused)
{
    (void)unused;
    uint64_t state = 41;
    const qs_encoding encodings[] = {QS_ONE_HOT, QS_ONE_HOT_SPARSE, QS_DOMAIN_WALL};
    for (int round = 0; round < 3 * ROUNDS; round++) {
        make_reduced(&state, encodings[round % 3]);
        int site[TINY_SITES];
        uint16_t labelling[TINY_SITES], of_model[TINY_SITES] = {0}, back[TINY_SITES];
        sites_of_model(site);
        slow_first(&request, labelling);
        int left = 100;
        do {
            for (uint32_t p = 0; p < model.sites; p++) {
                of_model[p] = site[p] < 0 ? 0 : labelling[site[p]];
            }
            assert_int_equal(qs_model_energy(&model, of_model), slow_energy(&t.problem, labelling));
        } while (--left > 0 && slow_next(&request, labelling));
        qs_model_sites(&model, of_model, back);
        for (uint32_t p = 0; p < model.sites; p++) {
            const int32_t *unary = model.unary + p * model.labels;
            int64_t weights = 0;
            if (model.width > 0) {
                weights = model.right[p] + (int64_t)model.down[p] +
                          (p > 0 ? model.right[p - 1] : 0) +
                          (p >= model.width ? model.down[p - model.width] : 0);
            }
            for (uint32_t n = 0;
                 model.width == 0 && n < model.link_start[p + 1] - model.link_start[p]; n++) {
                weights += model.links[model.link_start[p] + n].weight;
            }
            for (uint32_t d = 0; d < model.labels; d++) {
                bool is_left = site[p] < 0 || request.kept[site[p]][d];
                assert_int_equal(!model.kept || model.kept[p * model.labels + d], is_left);
                assert_true(is_left ? unary[d] >= 0 : unary[d] == weights * model.pairwise_max + 1);
            }
        }
    }
}

/* What one word of a wall's or another file's blocks, weights and terms decides is looked at. */
static void reduced_files_that_are_not_what_they_say(void **unused)
{
    (void)unused;
    uint64_t state = 42;
    uint32_t refused = 0;
    const qs_encoding encodings[] = {QS_ONE_HOT, QS_ONE_HOT_SPARSE, QS_DOMAIN_WALL};
    for (int round = 0; round < 3 * ROUNDS; round++) {
        make_reduced(&state, encodings[round % 3]);
        if (written.qubo.couplings == 0) {
            continue;
        }
        uint32_t b = tiny_random(&state, written.qubo.block_count);
        uint8_t *block =
            written.file + (written.qubo.blocks - written.file) + written.index.block_at[b];
        uint32_t rows = block[0], columns = block[4], r = tiny_random(&state, rows),
                 c = tiny_random(&state, columns), was;
        bool chain = false;
        for (uint32_t g = 0; g < written.qubo.groups; g++) {
            for (uint32_t n = written.index.near_start[g]; n < written.index.near_start[g + 1];
                 n++) {
                chain =
                    chain || (written.index.near[n].group == g && written.index.near[n].block == b);
            }
        }
        uint8_t *entry = block + 12 + 4 * (r * columns + c);
        bool matters = !chain || c > r;
        memcpy(&was, entry, sizeof was);
        memset(entry, 0, sizeof was);
        *entry = chain && c == r + 1 ? 0 : (uint8_t)(was ^ 0x40);
        bool table = model.pairwise.smoothness == QS_TABLE;
        qs_model changed;
        qs_status status =
            qs_model_build(&written.index, model_memory, sizeof model_memory, &changed);
        if (!table) {
            assert_int_equal(status, matters ? QS_E_CORRUPT : QS_OK);
        }
        refused += status == QS_E_CORRUPT;
        memcpy(entry, &was, sizeof was);
        if (written.qubo.labels.width > 1 && written.qubo.labels.height > 1 &&
            written.qubo.labels.width != written.qubo.labels.height) {
            uint32_t width = written.qubo.labels.width;
            written.qubo.labels.width = written.qubo.labels.height;
            written.qubo.labels.height = width;
            status = qs_model_build(&written.index, model_memory, sizeof model_memory, &changed);
            assert_true(status == QS_E_CORRUPT ||
                        status == QS_OK); /* what is left may fit either shape */
        }
    }
    assert_true(refused > ROUNDS);
}

static qs_status build_written(void)
{
    qs_model built;
    return qs_model_build(&written.index, model_memory, sizeof model_memory, &built);
}

/* Sites in a row, of three labels, with a table or Potts; one set of labels for each, bit by bit.
 */
static void write_row(qs_encoding encoding, qs_smoothness smoothness, uint32_t sites,
                      const uint8_t *sets)
{
    memset(&t, 0, sizeof t);
    for (uint32_t p = 0; p + 1 < sites; p++) {
        t.edges[p] = (qs_edge){p, p + 1, 5};
    }
    t.problem = (qs_problem){.sites = sites,
                             .labels = 3,
                             .scale = 1,
                             .pairwise = {smoothness, 0, t.table},
                             .edges = t.edges,
                             .edge_count = sites - 1,
                             .costs = t.costs};
    request = (slow_request){.problem = &t.problem, .encoding = encoding, .gap = 1};
    for (uint32_t p = 0; p < sites; p++) {
        for (uint32_t d = 0; d < 3; d++) {
            request.kept[p][d] = sets[p] >> d & 1;
        }
    }
    slow_encode(&request, &written);
}

/* Two blocks of one table differ; a block is used for a pair of sets that are not its own; a wall
 * has no chain; a Toeplitz block stands between sets with gaps. */
static void blocks_that_only_seem_right(void **unused)
{
    (void)unused;
    write_row(QS_ONE_HOT, QS_TABLE, 3, (const uint8_t[]){7, 7, 7});
    uint8_t *second =
        written.file + (written.qubo.blocks - written.file) + written.index.block_at[1];
    assert_int_equal(build_written(), QS_OK);
    second[12] = 3;
    assert_int_equal(build_written(), QS_E_CORRUPT);

    write_row(QS_ONE_HOT, QS_POTTS, 3, (const uint8_t[]){3, 3, 6});
    uint8_t *runs = written.file + (written.qubo.coupling_runs - written.file);
    assert_int_equal(build_written(), QS_OK);
    runs[48] = 0; /* the second run's block */
    assert_int_equal(
        qs_index_build(&written.qubo, written.memory, sizeof written.memory, &written.index),
        QS_OK);
    assert_int_equal(build_written(), QS_E_CORRUPT);

    write_row(QS_DOMAIN_WALL, QS_POTTS, 1, (const uint8_t[]){7});
    uint32_t none[2] = {0, 0};
    assert_int_equal(build_written(), QS_OK);
    written.index.near_start = none;
    assert_int_equal(build_written(), QS_E_CORRUPT);

    t.problem = (qs_problem){.sites = 2,
                             .labels = 3,
                             .scale = 1,
                             .pairwise = {QS_TRUNCATED_LINEAR, 0, NULL},
                             .edges = t.edges,
                             .edge_count = 1,
                             .costs = t.costs};
    t.edges[0] = (qs_edge){0, 1, 5};
    tiny_encode(&t.problem, (qs_encode_options){.encoding = QS_ONE_HOT}, &q);
    const uint8_t open[2] = {255, 255}, gaps[2] = {11, 11}, ranges[2] = {7, 14};
    q.qubo.labels.labels = 4;
    q.qubo.labels.fixed_bytes = 1;
    q.qubo.labels.fixed = open;
    q.qubo.labels.pairwise.truncation = 2;
    q.qubo.labels.sets = gaps; /* 0, 1, 3: first row and column are right, 1 and 3 are not */
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                     QS_E_CORRUPT);
    q.qubo.labels.sets = ranges;
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                     QS_E_CORRUPT);
    const uint8_t same[2] = {14, 14};
    q.qubo.labels.sets = same;
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model), QS_OK);
}

/* A table that couples nothing stands in block 0 of a whole file; what stands there must be one. */
static void tables_without_couplings(void **unused)
{
    (void)unused;
    const int32_t table[9] = {0, 3, 1, 2, 0, 7, 5, 4, 0};
    memset(&t, 0, sizeof t);
    memcpy(t.table, table, sizeof table);
    t.problem = (qs_problem){.sites = 1,
                             .labels = 3,
                             .scale = 1,
                             .pairwise = {QS_TABLE, 0, t.table},
                             .edges = t.edges,
                             .costs = t.costs};
    tiny_encode(&t.problem, (qs_encode_options){.encoding = QS_ONE_HOT}, &q);
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model), QS_OK);
    assert_memory_equal(model.pairwise.table, table, sizeof table);
    uint8_t *block = q.file + (q.qubo.blocks - q.file) + q.index.block_at[0];
    block[12 + 4 * 3 + 3] = 0x80; /* an entry below 0 */
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                     QS_E_CORRUPT);
    block[12 + 4 * 3 + 3] = 0;
    block[0] = 2; /* of another shape */
    assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                     QS_E_CORRUPT);
}

/* Cuts have no model. */
static void cuts_have_no_model(void **unused)
{
    (void)unused;
    uint64_t state = 43;
    tiny_make(&t, &state, BITS, true);
    request = (slow_request){.problem = &t.problem, .encoding = QS_MULTIWAY_CUT, .gap = 1};
    memset(request.kept, 1, sizeof request.kept);
    slow_encode(&request, &written);
    assert_int_equal(qs_model_build(&written.index, model_memory, sizeof model_memory, &model),
                     QS_E_ENCODING);
}

/* The file knows of the labels left alone, whose costs are small; the model says what the others
 * cost, too, and its sums stay within 2^60. */
static void sums_beyond_the_model_are_refused(void **unused)
{
    (void)unused;
    enum { MANY = 65535, BYTES = 4 * 2 * MANY + 2 * MANY + 256 };
    static uint64_t large[BYTES / 8 + 1];
    static uint8_t sets[2 * (MANY + 7) / 8];
    static const uint8_t open[4] = {255, 255, 255, 255};
    const int64_t largest = (int64_t)(MANY - 1) * (MANY - 1),
                  room = ((int64_t)1 << 60) - 2 * (int64_t)INT32_MAX;
    sets[0] = sets[(MANY + 7) / 8] = 3;
    for (int32_t over = 1; over >= 0; over--) {
        memset(&t, 0, sizeof t);
        t.edges[0] = (qs_edge){0, 1, (int32_t)(room / largest) + over};
        t.problem = (qs_problem){.sites = 2,
                                 .labels = 2,
                                 .scale = 1,
                                 .pairwise = {QS_TRUNCATED_QUADRATIC, 0, NULL},
                                 .edges = t.edges,
                                 .edge_count = 1,
                                 .costs = t.costs};
        tiny_encode(&t.problem, (qs_encode_options){.encoding = QS_ONE_HOT}, &q);
        q.qubo.labels.labels = MANY;
        q.qubo.labels.fixed_bytes = 2;
        q.qubo.labels.fixed = open;
        q.qubo.labels.sets = sets;
        assert_true(qs_model_workspace(&q.qubo) <= sizeof large);
        assert_int_equal(qs_model_build(&q.index, large, sizeof large, &model),
                         over ? QS_E_OVERFLOW : QS_OK);
    }
    assert_int_equal(model.pairwise_max, largest);
    assert_int_equal(qs_model_energy(&model, (const uint16_t[]){0, MANY - 1}),
                     room / largest * largest + INT32_MAX);
}

/* A cost takes all 31 bits of a model's, and no more. */
static void costs_at_the_edge_of_their_range(void **unused)
{
    (void)unused;
    for (int32_t over = 0; over < 2; over++) {
        memset(&t, 0, sizeof t);
        t.costs[0] = -over;
        t.costs[1] = t.costs[2] = INT32_MAX;
        t.problem = (qs_problem){.sites = 2, .labels = 2, .scale = 1, .costs = t.costs};
        tiny_encode(&t.problem, (qs_encode_options){.encoding = QS_ONE_HOT}, &q);
        assert_int_equal(qs_model_build(&q.index, model_memory, sizeof model_memory, &model),
                         over ? QS_E_OVERFLOW : QS_OK);
        assert_true(over || (model.unary[1] == INT32_MAX && model.unary[2] == INT32_MAX));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(model_has_the_problems_energy),
        cmocka_unit_test(links_are_sorted_and_numbered),
        cmocka_unit_test(winner_takes_all),
        cmocka_unit_test(costs_at_the_edge_of_their_range),
        cmocka_unit_test(strange_models),
        cmocka_unit_test(reduced_models_have_the_problems_energy),
        cmocka_unit_test(reduced_files_that_are_not_what_they_say),
        cmocka_unit_test(blocks_that_only_seem_right),
        cmocka_unit_test(tables_without_couplings),
        cmocka_unit_test(cuts_have_no_model),
        cmocka_unit_test(sums_beyond_the_model_are_refused),
    };
    return cmocka_run_group_tests_name("model", tests, NULL, NULL);
}
