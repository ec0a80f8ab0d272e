/* The model, and the solvers as their callers see them, beside every labelling of tiny problems. */
#include "slow.h"

#include <string.h>

enum { ROUNDS = 400, BITS = 24, MEMORY = 1 << 16 };

static tiny t;
static tiny_qubo q;
static uint64_t model_memory[MEMORY / 8], memory[MEMORY / 8];
static qs_model model;

static void make_model(uint64_t *state, bool potts, qs_encoding encoding)
{
    tiny_make(&t, state, BITS, potts);
    tiny_encode(&t.problem, (qs_encode_options){.encoding = encoding}, &q);
    assert_true(qs_model_workspace(&q.qubo) <= sizeof model_memory);
    assert_int_equal(qs_model_build(&q.index, model_memory, qs_model_workspace(&q.qubo), &model),
                     QS_OK);
}

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

static slow_qubo written;
static slow_request request;

/* A model of a file in which some labels are left. */
static void make_reduced(uint64_t *state, qs_encoding encoding)
{
    do {
        tiny_make(&t, state, BITS, false);
    } while (!slow_fits(&t.problem, encoding));
    request = (slow_request){.problem = &t.problem,
                             .encoding = encoding,
                             .gap = 1,
                             .truncate = tiny_random(state, 3) == 0};
    slow_choose_labels(&request, state);
    slow_encode(&request, &written);
    assert_true(qs_model_workspace(&written.qubo) <= sizeof model_memory);
    assert_int_equal(
        qs_model_build(&written.index, model_memory, qs_model_workspace(&written.qubo), &model),
        QS_OK);
}

/* The site of each of the model's, -1 where it is masked. */
static void sites_of_model(int site[TINY_SITES])
{
    int next = 0;
    for (uint32_t p = 0; p < model.sites; p++) {
        bool masked = model.mask && (model.mask[p / 8] >> p % 8 & 1) == 0;
        site[p] = masked ? -1 : next++;
    }
    assert_int_equal(next, qs_problem_sites(&t.problem));
}

/* Energies of all labellings of the labels left are the problem's; the others are told, and cost
 * more than their site's edges can. */
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

static const struct {
    const char *name;
    qs_solver *solve;
    size_t (*workspace)(const qs_model *);
    bool descends, bounds; /* never ends above its start; has lower bounds */
} solvers[] = {
    {"icm", qs_icm, qs_icm_workspace, true, false},
    {"anneal", qs_anneal, qs_anneal_workspace, true, false},
    {"expansion", qs_expansion, qs_expansion_workspace, true, false},
    {"swap", qs_swap, qs_swap_workspace, true, false},
    {"bp", qs_bp, qs_bp_workspace, false, false},
    {"trws", qs_trws, qs_trws_workspace, false, true},
    {"best", qs_best, qs_best_workspace, true, true},
    {"cut", qs_min_cut, qs_min_cut_workspace, true, true},
};
enum { SOLVERS = sizeof solvers / sizeof *solvers };

/* What a watch is told, and how often it lets the solver go on. */
typedef struct witness {
    const uint16_t *labelling;
    int64_t optimum;
    uint64_t calls, patience;
} witness;

static bool watch(void *context, const qs_progress *progress)
{
    witness *w = context;
    assert_int_equal(qs_model_energy(&model, w->labelling), progress->energy);
    assert_true(progress->energy >= w->optimum);
    assert_true(progress->lower_bound <= w->optimum);
    return ++w->calls < w->patience;
}

static bool watch_anything(void *context, const qs_progress *progress)
{
    witness *w = context;
    assert_int_equal(qs_model_energy(&model, w->labelling), progress->energy);
    return ++w->calls < w->patience;
}

static void every_solver_keeps_its_word(void **unused)
{
    (void)unused;
    uint64_t state = 25;
    uint32_t proven[SOLVERS] = {0}, optimal[SOLVERS] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        make_model(&state, round % 2 == 0, QS_ENCODING_DEFAULT);
        int64_t optimum = tiny_minimum(&t.problem);
        for (size_t i = 0; i < SOLVERS; i++) {
            uint16_t labelling[TINY_SITES], again[TINY_SITES];
            qs_solution solution, second;
            witness w = {labelling, optimum, 0, UINT64_MAX};
            qs_solve_options options = {.iterations = 60, .seed = 7, .watch = watch, .context = &w};
            size_t size = solvers[i].workspace(&model);
            assert_true(size <= sizeof memory);
            qs_model_winner(&model, labelling);
            int64_t start = qs_model_energy(&model, labelling);
            qs_status status =
                solvers[i].solve(&model, &options, memory, size, labelling, &solution);
            if (status == QS_E_ENCODING) {
                assert_true(solvers[i].solve == qs_min_cut);
                continue;
            }
            assert_int_equal(status, QS_OK);
            assert_true(w.calls >=
                        solution.iterations); /* none for one label, which has no moves */
            assert_int_equal(solution.energy, qs_model_energy(&model, labelling));
            assert_true(solution.energy >= optimum &&
                        (solution.energy <= start || !solvers[i].descends));
            assert_true(solvers[i].bounds ? solution.lower_bound <= optimum
                                          : solution.lower_bound == QS_NO_BOUND);
            proven[i] += solution.lower_bound == solution.energy;
            optimal[i] += solution.energy == optimum;
            w.labelling = again;
            qs_model_winner(&model, again);
            memset(memory, 0x5a, sizeof memory); /* what the workspace held must not matter */
            assert_int_equal(solvers[i].solve(&model, &options, memory, size, again, &second),
                             QS_OK);
            assert_memory_equal(again, labelling, sizeof *again * model.sites);
            assert_memory_equal(&second.energy, &solution.energy, sizeof second.energy);
            assert_int_equal(second.iterations, solution.iterations);
        }
    }
    /* Tiny problems are easy: the strong solvers must mostly find the optimum, the bounds mostly
     * prove it. */
    for (size_t i = 2; i < SOLVERS; i++) {
        print_message("%-9s optimal in %u, proven in %u of %d\n", solvers[i].name, optimal[i],
                      proven[i], ROUNDS);
    }
    assert_true(optimal[6] > ROUNDS * 19 / 20 && proven[6] > ROUNDS * 17 / 20);
    assert_true(proven[5] > ROUNDS * 17 / 20);
}

static void watches_stop(void **unused)
{
    (void)unused;
    uint64_t state = 26;
    for (int round = 0; round < ROUNDS / 4; round++) {
        make_model(&state, true, QS_ENCODING_DEFAULT);
        int64_t optimum = tiny_minimum(&t.problem);
        for (size_t i = 0; i < SOLVERS; i++) {
            uint16_t labelling[TINY_SITES];
            qs_solution solution;
            witness w = {labelling, optimum, 0, 1 + tiny_random(&state, 3)};
            qs_solve_options options = {.watch = watch, .context = &w};
            qs_model_winner(&model, labelling);
            qs_status status =
                solvers[i].solve(&model, &options, memory, sizeof memory, labelling, &solution);
            if (status == QS_E_ENCODING && solvers[i].solve == qs_min_cut) {
                continue;
            }
            assert_int_equal(status, QS_OK);
            assert_true(w.calls <= w.patience);
            assert_int_equal(solution.energy, qs_model_energy(&model, labelling));
        }
    }
}

/* Stopped at any moment, begun anywhere: no solver returns a label that is not left, and its energy
 * is the problem's. */
static void labels_that_are_out_stay_out(void **unused)
{
    (void)unused;
    uint64_t state = 30;
    for (int round = 0; round < 3 * ROUNDS; round++) {
        make_reduced(&state, (qs_encoding)(1 + round % 3));
        int site[TINY_SITES];
        sites_of_model(site);
        uint16_t optimum[TINY_SITES];
        int64_t least = INT64_MAX;
        slow_first(&request, optimum);
        do {
            int64_t energy = slow_energy(&t.problem, optimum);
            least = energy < least ? energy : least;
        } while (tiny_random(&state, 400) > 0 && slow_next(&request, optimum));
        for (size_t i = 0; i < SOLVERS; i++) {
            uint16_t labelling[TINY_SITES], sites[TINY_SITES];
            qs_solution solution;
            witness w = {labelling, INT64_MIN, 0, round % 2 == 0 ? 1 : 1 + tiny_random(&state, 4)};
            qs_solve_options options = {.iterations = 60, .watch = watch_anything, .context = &w};
            qs_model_winner(&model, labelling);
            for (uint32_t p = 0; round % 3 == 0 && p < model.sites; p++) {
                labelling[p] = (uint16_t)tiny_random(&state, model.labels);
            }
            qs_status status =
                solvers[i].solve(&model, &options, memory, sizeof memory, labelling, &solution);
            if (status == QS_E_ENCODING) {
                continue;
            }
            assert_int_equal(status, QS_OK);
            for (uint32_t p = 0; p < model.sites; p++) {
                assert_true(site[p] < 0 || request.kept[site[p]][labelling[p]]);
            }
            qs_model_sites(&model, labelling, sites);
            assert_int_equal(solution.energy, slow_energy(&t.problem, sites));
            assert_true(solution.lower_bound <= least);
        }
    }
}

/* Edges so heavy that no cost of 32 bits keeps a label out: between {0, 5} and {2, 3} every
 * labelling costs more than one with a label that is not left. */
static void labels_stay_out_beside_heavy_edges(void **unused)
{
    (void)unused;
    uint32_t answered = 0;
    memset(&t, 0, sizeof t);
    t.edges[0] = (qs_edge){0, 1, INT32_MAX};
    t.problem = (qs_problem){.sites = 2,
                             .labels = 6,
                             .scale = 1,
                             .pairwise = {QS_TRUNCATED_LINEAR, 0, NULL},
                             .edges = t.edges,
                             .edge_count = 1,
                             .costs = t.costs};
    request = (slow_request){.problem = &t.problem, .encoding = QS_ONE_HOT, .gap = 1};
    request.kept[0][0] = request.kept[0][5] = request.kept[1][2] = request.kept[1][3] = true;
    slow_encode(&request, &written);
    assert_int_equal(qs_model_build(&written.index, model_memory, sizeof model_memory, &model),
                     QS_OK);
    for (size_t i = 0; i < 2 * SOLVERS; i++) {
        uint16_t labelling[2] = {2, 2}; /* cheaper than all that is left */
        qs_solution solution;
        if (i >= SOLVERS) {
            qs_model_winner(&model, labelling);
        }
        qs_status status =
            solvers[i % SOLVERS].solve(&model, NULL, memory, sizeof memory, labelling, &solution);
        if (status == QS_OK) {
            answered++;
            assert_true(request.kept[0][labelling[0]] && request.kept[1][labelling[1]]);
            assert_int_equal(solution.energy, slow_energy(&t.problem, labelling));
        } else {
            assert_int_equal(status, QS_E_OVERFLOW);
        }
    }
    assert_true(answered >= 4); /* others refuse such edges */
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

static void small_workspaces_are_refused(void **unused)
{
    (void)unused;
    uint64_t state = 27;
    make_model(&state, true, QS_ENCODING_DEFAULT);
    for (size_t i = 0; i < SOLVERS; i++) {
        uint16_t labelling[TINY_SITES] = {0};
        qs_solution solution;
        size_t size = solvers[i].workspace(&model);
        if (size > 0) {
            assert_int_equal(solvers[i].solve(&model, NULL, memory, size - 1, labelling, &solution),
                             QS_E_WORKSPACE);
        }
        assert_int_equal(solvers[i].solve(NULL, NULL, memory, size, labelling, &solution),
                         QS_E_ARGUMENT);
    }
}

/* No site of icm's answer can be improved by itself; equal labels go to the lowest. */
static void icm_ends_in_a_local_minimum(void **unused)
{
    (void)unused;
    uint64_t state = 28;
    for (int round = 0; round < ROUNDS; round++) {
        make_model(&state, round % 2 == 0, QS_ENCODING_DEFAULT);
        uint16_t labelling[TINY_SITES];
        qs_solution solution;
        qs_model_winner(&model, labelling);
        assert_int_equal(qs_icm(&model, NULL, NULL, 0, labelling, &solution), QS_OK);
        assert_true(solution.converged);
        for (uint32_t p = 0; p < model.sites; p++) {
            uint16_t kept = labelling[p];
            for (uint16_t d = 0; d < model.labels; d++) {
                labelling[p] = d;
                int64_t energy = qs_model_energy(&model, labelling);
                assert_true(d < kept ? energy > solution.energy : energy >= solution.energy);
            }
            labelling[p] = kept;
        }
    }
}

/* With many sweeps annealing finds the optimum of most tiny problems; other seeds go other ways. */
static void annealing_anneals(void **unused)
{
    (void)unused;
    uint64_t state = 29;
    uint32_t optimal = 0, differing = 0;
    for (int round = 0; round < 100; round++) {
        make_model(&state, true, QS_ENCODING_DEFAULT);
        uint16_t labelling[TINY_SITES], other[TINY_SITES];
        qs_solution solution, second;
        qs_solve_options options = {.iterations = 300, .seed = 1};
        qs_model_winner(&model, labelling);
        assert_int_equal(qs_anneal(&model, &options, memory, sizeof memory, labelling, &solution),
                         QS_OK);
        optimal += solution.energy == tiny_minimum(&t.problem);
        options = (qs_solve_options){.iterations = 1, .seed = 2};
        qs_model_winner(&model, other);
        assert_int_equal(qs_anneal(&model, &options, memory, sizeof memory, other, &second), QS_OK);
        differing += memcmp(other, labelling, sizeof *other * model.sites) != 0;
    }
    assert_true(optimal >= 90);
    assert_true(differing > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(model_has_the_problems_energy),
        cmocka_unit_test(links_are_sorted_and_numbered),
        cmocka_unit_test(winner_takes_all),
        cmocka_unit_test(strange_models),
        cmocka_unit_test(every_solver_keeps_its_word),
        cmocka_unit_test(watches_stop),
        cmocka_unit_test(small_workspaces_are_refused),
        cmocka_unit_test(icm_ends_in_a_local_minimum),
        cmocka_unit_test(annealing_anneals),
        cmocka_unit_test(reduced_models_have_the_problems_energy),
        cmocka_unit_test(cuts_have_no_model),
        cmocka_unit_test(reduced_files_that_are_not_what_they_say),
        cmocka_unit_test(labels_that_are_out_stay_out),
        cmocka_unit_test(blocks_that_only_seem_right),
        cmocka_unit_test(tables_without_couplings),
        cmocka_unit_test(labels_stay_out_beside_heavy_edges),
        cmocka_unit_test(sums_beyond_the_model_are_refused),
    };
    return cmocka_run_group_tests_name("solve", tests, NULL, NULL);
}
