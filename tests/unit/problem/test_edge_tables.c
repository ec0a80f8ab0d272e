/* Problems whose edges have tables of their own and whose sites have forbidden labels: all that the
 * library makes of them, beside F computed plainly and every labelling of tiny problems. */
#include "tiny.h"

#include <string.h>

enum { ROUNDS = 250, BITS = 12, MEMORY = 1 << 17, ENTRIES = TINY_LABELS * TINY_LABELS };

/* A tiny problem with its tables, by edge of the list or by cell and direction. */
typedef struct specimen {
    tiny t;
    int32_t tables[2 * TINY_SITES > TINY_EDGES ? 2 * TINY_SITES : TINY_EDGES][ENTRIES];
    int32_t list[TINY_EDGES * ENTRIES];
    uint8_t allowed[TINY_SITES * TINY_LABELS];
} specimen;

static specimen s;
static tiny_qubo q, again;
static uint64_t memory[MEMORY / 8], model_memory[MEMORY / 8], file_model_memory[MEMORY / 8];
static qs_model model, file_model;
static qs_labels labels;

static void put_tables(void *context, uint32_t row, int32_t *right, int32_t *down)
{
    const specimen *of = context;
    const qs_problem *p = &of->t.problem;
    size_t entries = (size_t)p->labels * p->labels, size = entries * sizeof *right;
    for (uint32_t x = 0; x < p->grid.width; x++) {
        uint32_t cell = row * p->grid.width + x;
        if (right && x + 1 < p->grid.width) {
            memcpy(right + x * entries, of->tables[2 * cell], size);
        }
        if (down) {
            memcpy(down + x * entries, of->tables[2 * cell + 1], size);
        }
    }
}

static void make_tables(uint64_t *state)
{
    qs_problem *p = &s.t.problem;
    uint32_t entries = p->labels * p->labels, count = sizeof s.tables / sizeof *s.tables;
    uint32_t repeats = tiny_random(state, 3);
    for (uint32_t i = 0; i < count; i++) {
        bool same = i > 1 && tiny_random(state, 4) < repeats, zero = tiny_random(state, 8) == 0;
        for (uint32_t k = 0; k < entries; k++) {
            int32_t entry = zero ? 0 : (int32_t)tiny_random(state, 9);
            s.tables[i][k] = same ? s.tables[i - 2][k] : entry;
        }
    }
    for (size_t e = 0; e < p->edge_count; e++) {
        memcpy(s.list + e * entries, s.tables[e], entries * sizeof *s.list);
    }
    p->pairwise = (qs_pairwise){.smoothness = QS_TABLES};
    if (p->grid.width > 0) {
        p->table_source = (qs_table_source){put_tables, &s};
    } else {
        p->tables = s.list;
    }
}

static void forbid(uint64_t *state)
{
    qs_problem *p = &s.t.problem;
    uint32_t one_in = 1 + tiny_random(state, 4);
    for (uint32_t site = 0; site < qs_problem_sites(p); site++) {
        uint8_t *allowed = s.allowed + site * p->labels;
        for (uint32_t d = 0; d < p->labels; d++) {
            allowed[d] = tiny_random(state, one_in) == 0 ? 7 : 0;
        }
        allowed[tiny_random(state, p->labels)] = 1;
    }
    p->allowed = s.allowed;
}

/* One problem in three keeps its own pairwise cost: sets of labels go with every cost. */
static void make(uint64_t *state, int round, bool sets)
{
    memset(&s, 0, sizeof s);
    tiny_make(&s.t, state, BITS, false);
    if (round % 3 != 0 || !sets) {
        make_tables(state);
    }
    if (sets) {
        forbid(state);
    }
}

/* ---- F, plainly. ---- */

static int64_t edge_cost(const qs_problem *p, const int32_t *table, uint32_t a, uint32_t b)
{
    bool tables = p->pairwise.smoothness == QS_TABLES;
    return tables ? table[a * p->labels + b] : qs_pairwise_cost(p, a, b);
}

static int64_t grid_energy(const qs_problem *p, const uint16_t *x)
{
    int site[TINY_SITES], next = 0;
    const qs_grid *grid = &p->grid;
    uint32_t width = grid->width, cells = width * grid->height;
    int64_t energy = 0;
    for (uint32_t c = 0; c < cells; c++) {
        site[c] = grid->mask && grid->mask[c] == 0 ? -1 : next++;
    }
    for (uint32_t c = 0; c < cells; c++) {
        bool right = (c + 1) % width != 0 && site[c] >= 0 && site[c + 1] >= 0;
        bool down = c + width < cells && site[c] >= 0 && site[c + width] >= 0;
        if (right) {
            energy += (grid->right ? grid->right[c] : p->weight) *
                      edge_cost(p, s.tables[2 * c], x[site[c]], x[site[c + 1]]);
        }
        if (down) {
            energy += (grid->down ? grid->down[c] : p->weight) *
                      edge_cost(p, s.tables[2 * c + 1], x[site[c]], x[site[c + width]]);
        }
    }
    return energy;
}

static int64_t plain_energy(const qs_problem *p, const uint16_t *x)
{
    int64_t energy = p->grid.width > 0 ? grid_energy(p, x) : 0;
    for (uint32_t site = 0; site < qs_problem_sites(p); site++) {
        energy += p->costs[site * p->labels + x[site]];
    }
    for (size_t e = 0; e < p->edge_count; e++) {
        const qs_edge *edge = &p->edges[e];
        energy += edge->weight * edge_cost(p, s.tables[e], x[edge->first], x[edge->second]);
    }
    return energy;
}

static bool is_allowed(const qs_problem *p, const uint16_t *x)
{
    for (uint32_t site = 0; p->allowed && site < qs_problem_sites(p); site++) {
        if (p->allowed[site * p->labels + x[site]] == 0) {
            return false;
        }
    }
    return true;
}

static bool next_labelling(const qs_problem *p, uint16_t *x)
{
    for (uint32_t site = 0; site < qs_problem_sites(p); site++) {
        if (++x[site] < p->labels) {
            return true;
        }
        x[site] = 0;
    }
    return false;
}

static int64_t plain_minimum(const qs_problem *p)
{
    uint16_t x[TINY_SITES] = {0};
    int64_t least = INT64_MAX;
    do {
        int64_t energy = is_allowed(p, x) ? plain_energy(p, x) : INT64_MAX;
        least = energy < least ? energy : least;
    } while (next_labelling(p, x));
    return least;
}

/* ---- Helpers. ---- */

static void model_of_problem(void)
{
    size_t size = qs_model_of_problem_workspace(&s.t.problem);
    assert_true(size <= sizeof model_memory);
    memset(model_memory, 0xa5, sizeof model_memory);
    assert_int_equal(qs_model_of_problem(&s.t.problem, model_memory, size, &model, &labels), QS_OK);
}

static void model_of_file(void)
{
    size_t size = qs_model_workspace(&q.qubo);
    assert_true(size <= sizeof file_model_memory);
    memset(file_model_memory, 0xa5, sizeof file_model_memory);
    assert_int_equal(qs_model_build(&q.index, file_model_memory, size, &file_model), QS_OK);
}

static void open_file(tiny_qubo *of)
{
    assert_int_equal(qs_qubo_open(of->file, of->size, TINY_INDEX, &of->qubo, NULL), QS_OK);
    assert_int_equal(
        qs_index_build(&of->qubo, of->memory, qs_index_workspace(&of->qubo), &of->index), QS_OK);
}

static void recode(const qs_model *of, const qs_labels *said, qs_recode_options options,
                   tiny_qubo *to)
{
    qs_buffer buffer = {to->file, sizeof to->file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    size_t size = qs_recode_workspace(of, &options);
    assert_true(size <= sizeof memory);
    assert_int_equal(qs_recode(of, said, &options, &sink, memory, size, NULL), QS_OK);
    to->size = buffer.size;
    open_file(to);
}

/* From a labelling of the problem's sites to one of the model's. */
static void to_model(const qs_model *of, const uint16_t *x, uint16_t *y)
{
    for (uint32_t p = 0; p < of->sites; p++) {
        bool masked = of->mask && (of->mask[p / 8] >> p % 8 & 1) == 0;
        y[p] = masked ? 0 : *x++;
    }
}

/* Compares the energies of all labellings that are allowed: of the problem, of both models, and H
 * of the file. */
static void compare_energies(void)
{
    const qs_problem *p = &s.t.problem;
    uint16_t x[TINY_SITES] = {0}, y[TINY_SITES];
    do {
        int64_t energy, plain = plain_energy(p, x);
        uint8_t bits[4] = {0};
        qs_status status = qs_problem_energy(p, x, memory, qs_problem_workspace(p), &energy);
        assert_int_equal(status, is_allowed(p, x) ? QS_OK : QS_E_ARGUMENT);
        if (status != QS_OK) {
            assert_int_equal(qs_sample_encode(&q.index, x, bits), QS_E_ARGUMENT);
            continue;
        }
        assert_int_equal(energy, plain);
        to_model(&model, x, y);
        assert_int_equal(qs_model_energy(&model, y), plain);
        assert_int_equal(qs_model_energy(&file_model, y), plain);
        assert_int_equal(qs_sample_encode(&q.index, x, bits), QS_OK);
        assert_int_equal(qs_qubo_energy(&q.index, bits), plain);
    } while (next_labelling(p, x));
}

/* The least H over all states is the least F, and no infeasible one is within the gap of it. Its
 * repair is a labelling, and lower by the gap. */
static void compare_states(int64_t least, int64_t gap, uint64_t *state)
{
    int64_t found = INT64_MAX;
    assert_true(q.qubo.variables <= BITS);
    for (uint32_t x = 0; x >> q.qubo.variables == 0; x++) {
        uint8_t bits[4];
        tiny_bits(x, bits);
        int64_t energy = qs_qubo_energy(&q.index, bits);
        found = energy < found ? energy : found;
        if (qs_sample_infeasible(&q.index, bits) == 0) {
            continue;
        }
        assert_true(energy >= least + gap);
        if (tiny_random(state, 8) == 0) {
            size_t size = qs_repair_workspace(&q.index);
            assert_true(size <= sizeof memory);
            assert_int_equal(qs_sample_repair(&q.index, bits, memory, size, NULL), QS_OK);
            assert_int_equal(qs_sample_infeasible(&q.index, bits), 0);
            assert_true(qs_qubo_energy(&q.index, bits) <= energy - gap);
        }
    }
    assert_int_equal(found, least);
}

/* ---- Tests. ---- */

/* Whole problems are streamed; written from the model they have the same bytes. */
static void tables_in_files(void **unused)
{
    (void)unused;
    uint64_t state = 301;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state, round, false);
        static const qs_penalty penalties[] = {QS_PENALTY_LOCAL, QS_PENALTY_PAPER,
                                               QS_PENALTY_MINIMAL};
        qs_encode_options options = {.penalty = penalties[round % 3]};
        tiny_encode(&s.t.problem, options, &q);
        assert_int_equal(q.qubo.labels.encoding, QS_ONE_HOT);
        assert_int_equal(q.qubo.labels.pairwise.smoothness, QS_TABLES);
        model_of_problem();
        model_of_file();
        compare_energies();
        compare_states(plain_minimum(&s.t.problem), 1, &state);
        recode(&model, &labels, (qs_recode_options){.encode = options}, &again);
        /* The paper's alpha also counts the least costs, which differ from one site's largest. */
        if (options.penalty != QS_PENALTY_PAPER) {
            assert_int_equal(again.size, q.size);
            assert_memory_equal(again.file, q.file, q.size);
        }
        recode(&file_model, &q.qubo.labels, (qs_recode_options){.encode = options}, &again);
        if (options.penalty != QS_PENALTY_PAPER) {
            assert_int_equal(again.size, q.size);
            assert_memory_equal(again.file, q.file, q.size);
        }
    }
}

static bool is_left(uint32_t site, uint32_t label)
{
    return !file_model.kept || file_model.kept[site * file_model.labels + label] != 0;
}

/* The least that an edge costs with a label of one end; `back`: of its second end. */
static int64_t least_of_line(uint32_t edge, uint32_t far, uint32_t label, bool back)
{
    int64_t least = INT64_MAX;
    for (uint32_t other = 0; other < file_model.labels; other++) {
        if (is_left(far, other)) {
            int64_t cost = qs_model_edge_pairwise(&file_model, edge, back ? other : label,
                                                  back ? label : other);
            least = cost < least ? cost : least;
        }
    }
    return least;
}

static void assert_least_is_0(uint32_t edge, uint32_t first, uint32_t second)
{
    for (uint32_t label = 0; label < file_model.labels; label++) {
        if (is_left(first, label)) {
            assert_int_equal(least_of_line(edge, second, label, false), 0);
        }
        if (is_left(second, label)) {
            assert_int_equal(least_of_line(edge, first, label, true), 0);
        }
    }
}

/* Of a domain wall: what an edge costs with one label of a site, whatever the other end has, is a
 * cost of that site. */
static void tables_of_walls_are_lifted(void)
{
    const qs_model *m = &file_model;
    for (uint32_t p = 0; p < m->sites && m->width > 0; p++) {
        if ((p + 1) % m->width != 0) {
            assert_least_is_0(2 * p, p, p + 1);
        }
        if (p + m->width < m->sites) {
            assert_least_is_0(2 * p + 1, p, p + m->width);
        }
    }
    for (uint32_t p = 0; p < m->sites && m->width == 0; p++) {
        for (uint32_t n = m->link_start[p]; n < m->link_start[p + 1]; n++) {
            if (m->links[n].site > p) {
                assert_least_is_0(m->links[n].edge, p, m->links[n].site);
            }
        }
    }
}

/* Sums of a wall's block that leave 32 bits are refused. */
static void tables_of_walls_are_not_too_large(void **unused)
{
    (void)unused;
    memset(&s, 0, sizeof s);
    s.t.edges[0] = (qs_edge){0, 1, 1};
    s.t.problem = (qs_problem){.sites = 2,
                               .labels = 3,
                               .scale = 1,
                               .pairwise = {.smoothness = QS_TABLES},
                               .edges = s.t.edges,
                               .edge_count = 1,
                               .tables = s.list,
                               .costs = s.t.costs};
    for (uint32_t i = 0; i < 9; i++) {
        s.list[i] = i == 4 || i == 8;
    }
    model_of_problem();
    recode(&model, &labels, (qs_recode_options){.encode = {.encoding = QS_DOMAIN_WALL, .gap = 1}},
           &q);
    model_of_file();
    uint8_t *entry = q.file + (q.qubo.blocks - q.file) + q.index.block_at[0] + 12;
    memset(entry, 0, 16);
    entry[3] = 0x30; /* 3 x 2^28, */
    model_of_file();
    entry[15] = 0x30; /* and as much again */
    size_t size = qs_model_workspace(&q.qubo);
    assert_int_equal(qs_model_build(&q.index, file_model_memory, size, &file_model), QS_E_CORRUPT);
}

/* Forbidden labels have no variables, in every encoding that holds the pairwise cost. */
static void forbidden_labels_in_files(void **unused)
{
    (void)unused;
    uint64_t state = 302;
    uint32_t walls = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state, round, true);
        const qs_problem *p = &s.t.problem;
        int64_t least = plain_minimum(p);
        model_of_problem();
        uint32_t left = 0, all = qs_problem_sites(p) * p->labels;
        for (uint32_t i = 0; i < all; i++) {
            left += p->allowed[i] != 0;
        }
        assert_true((model.kept == NULL) == (left == all));
        qs_encoding encoding = (qs_encoding)(1 + tiny_random(&state, 3));
        if (!qs_encoding_holds(encoding, &p->pairwise, p->labels)) {
            encoding = QS_ONE_HOT;
        }
        qs_recode_options options = {
            .encode = {.encoding = encoding, .gap = 1 + tiny_random(&state, 4)},
            .truncate = round % 5 == 0};
        recode(&model, &labels, options, &q);
        assert_true(q.qubo.variables <= left);
        model_of_file();
        if (q.qubo.labels.trimmed == NULL) {
            compare_energies();
        }
        if (encoding == QS_DOMAIN_WALL && p->pairwise.smoothness == QS_TABLES) {
            tables_of_walls_are_lifted();
            walls++;
        }
        /* A reader of walls shares the terms of one site out differently: kappa may differ. */
        if (q.qubo.labels.trimmed == NULL && encoding != QS_DOMAIN_WALL) {
            recode(&file_model, &q.qubo.labels, options, &again);
            assert_int_equal(again.size, q.size);
            assert_memory_equal(again.file, q.file, q.size);
        }
        compare_states(least, (int64_t)options.encode.gap, &state);
        uint64_t encode_memory[8192];
        qs_encode_options one_hot = {.encoding = QS_ONE_HOT};
        assert_int_equal(qs_encode(p, &one_hot, NULL, encode_memory, qs_encode_workspace(p), NULL),
                         left == all ? QS_OK : QS_E_ENCODING);
    }
    assert_true(walls > ROUNDS / 8);
}

static const struct {
    const char *name;
    qs_solver *solve;
    size_t (*workspace)(const qs_model *);
} solvers[] = {
    {"icm", qs_icm, qs_icm_workspace},
    {"anneal", qs_anneal, qs_anneal_workspace},
    {"bp", qs_bp, qs_bp_workspace},
    {"trws", qs_trws, qs_trws_workspace},
    {"swap", qs_swap, qs_swap_workspace},
    {"expansion", qs_expansion, qs_expansion_workspace},
    {"cut", qs_min_cut, qs_min_cut_workspace},
    {"best", qs_best, qs_best_workspace},
};
enum { SOLVERS = sizeof solvers / sizeof *solvers };

static void check_solution(size_t solver, int64_t least, const uint16_t *y,
                           const qs_solution *solution, uint32_t *optimal)
{
    const qs_problem *p = &s.t.problem;
    uint16_t x[TINY_SITES];
    qs_model_sites(&model, y, x);
    assert_true(is_allowed(p, x));
    assert_int_equal(solution->energy, plain_energy(p, x));
    assert_true(solution->energy >= least);
    assert_true(solution->lower_bound <= least);
    optimal[solver] += solution->energy == least;
}

static void solvers_take_tables_and_sets(void **unused)
{
    (void)unused;
    uint64_t state = 303;
    uint32_t optimal[SOLVERS] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        make(&state, round, round % 2 == 0);
        int64_t least = plain_minimum(&s.t.problem);
        model_of_problem();
        for (size_t i = 0; i < SOLVERS; i++) {
            uint16_t y[TINY_SITES];
            qs_solution solution;
            qs_solve_options options = {.iterations = 80, .seed = 5};
            size_t size = solvers[i].workspace(&model);
            assert_true(size <= sizeof memory);
            qs_model_winner(&model, y);
            for (uint32_t p = 0; round % 4 == 1 && p < model.sites; p++) {
                y[p] = (uint16_t)tiny_random(&state, model.labels);
            }
            int64_t start = qs_model_energy(&model, y);
            qs_status status = solvers[i].solve(&model, &options, memory, size, y, &solution);
            if (status == QS_E_ENCODING) {
                assert_true(solvers[i].solve == qs_min_cut);
                continue;
            }
            assert_int_equal(status, QS_OK);
            check_solution(i, least, y, &solution, optimal);
            /* Moves never raise the energy. */
            assert_true(solution.energy <= start || model.kept || solvers[i].solve == qs_bp ||
                        solvers[i].solve == qs_trws);
        }
    }
    for (size_t i = 0; i < SOLVERS; i++) {
        print_message("%-9s optimal in %u of %d\n", solvers[i].name, optimal[i], ROUNDS);
    }
    assert_true(optimal[2] > ROUNDS * 98 / 100); /* bp */
    assert_true(optimal[3] > ROUNDS * 17 / 20); /* trws */
    assert_true(optimal[5] > ROUNDS * 15 / 20); /* expansion */
    assert_true(optimal[7] > ROUNDS * 19 / 20); /* best */
}

/* A reduction keeps the least energy, and its file the energies of all labellings left. */
static void reductions_keep_the_optimum(void **unused)
{
    (void)unused;
    uint64_t state = 304;
    uint32_t gone = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state, round, round % 2 == 0);
        const qs_problem *p = &s.t.problem;
        int64_t least = plain_minimum(p);
        model_of_problem();
        uint8_t kept[TINY_SITES * TINY_LABELS];
        uint16_t y[TINY_SITES], x[TINY_SITES];
        qs_reduction found;
        qs_reduce_options options = {.iterations = 1 + tiny_random(&state, 40)};
        size_t size = qs_reduce_workspace(&model);
        assert_true(size <= sizeof memory);
        assert_int_equal(qs_reduce(&model, &options, memory, size, kept, y, &found), QS_OK);
        qs_model_sites(&model, y, x);
        assert_true(is_allowed(p, x));
        assert_int_equal(found.upper_bound, plain_energy(p, x));
        assert_true(found.lower_bound <= least && least <= found.upper_bound);
        recode(&model, &labels,
               (qs_recode_options){.encode = {.encoding = QS_ONE_HOT}, .kept = kept}, &q);
        gone += q.qubo.variables < qs_problem_sites(p) * p->labels;
        compare_states(least, 1, &state);
        model_of_file();
        assert_int_equal(qs_model_energy(&file_model, y), found.upper_bound);
    }
    assert_true(gone > ROUNDS / 2);
}

/* An energy of 2^53 is the largest: one unit more, of either kind of cost, is too much. */
static void largest_energy(void **unused)
{
    (void)unused;
    int32_t costs[2] = {0}, tables[1] = {1 << 30};
    uint16_t labelling[2] = {0};
    int64_t energy;
    qs_edge edge = {0, 1, 1 << 23};
    qs_problem p = {.sites = 2,
                    .labels = 1,
                    .scale = 1,
                    .edges = &edge,
                    .edge_count = 1,
                    .costs = costs,
                    .tables = tables,
                    .pairwise = {.smoothness = QS_TABLES}};
    assert_int_equal(qs_problem_energy(&p, labelling, NULL, 0, &energy), QS_OK);
    assert_int_equal(energy, QS_ENERGY_MAX);
    costs[1] = 1;
    assert_int_equal(qs_problem_energy(&p, labelling, NULL, 0, &energy), QS_E_OVERFLOW);
    costs[1] = -1;
    tables[0]++;
    assert_int_equal(qs_problem_energy(&p, labelling, NULL, 0, &energy), QS_E_OVERFLOW);
}

static void refusals(void **unused)
{
    (void)unused;
    int32_t costs[4] = {0}, tables[4] = {0, 1, 1, 0};
    uint8_t allowed[4] = {1, 0, 0, 1};
    uint16_t labelling[2] = {0, 1};
    int64_t energy;
    qs_edge edge = {0, 1, 3};
    qs_problem p = {.sites = 2,
                    .labels = 2,
                    .scale = 1,
                    .edges = &edge,
                    .edge_count = 1,
                    .costs = costs,
                    .allowed = allowed,
                    .tables = tables,
                    .pairwise = {.smoothness = QS_TABLES}};
    assert_int_equal(qs_problem_check(&p), QS_OK);
    assert_int_equal(qs_problem_energy(&p, labelling, NULL, 0, &energy), QS_OK);
    assert_int_equal(energy, 3);
    allowed[3] = 0; /* no label is left to the second site */
    assert_int_equal(qs_problem_check(&p), QS_E_ARGUMENT);
    allowed[3] = 1;
    tables[2] = -1;
    assert_int_equal(qs_problem_check(&p), QS_E_ARGUMENT);
    tables[2] = 0;
    p.tables = NULL;
    assert_int_equal(qs_problem_check(&p), QS_E_ARGUMENT);
    p.edge_count = 0;
    assert_int_equal(qs_problem_check(&p), QS_OK);
    p.pairwise.smoothness = (qs_smoothness)5;
    assert_int_equal(qs_problem_check(&p), QS_E_ARGUMENT);
    p = (qs_problem){.labels = 2,
                     .scale = 1,
                     .weight = 1,
                     .grid = {.width = 2, .height = 1},
                     .costs = costs,
                     .pairwise = {.smoothness = QS_TABLES}};
    assert_int_equal(qs_problem_check(&p), QS_E_ARGUMENT); /* no source */
}

/* Tables that a source makes are looked at when they are used. */
static void made_tables_are_checked(void **unused)
{
    (void)unused;
    memset(&s, 0, sizeof s);
    int64_t energy;
    uint16_t labelling[2] = {0, 1};
    s.t.problem = (qs_problem){.labels = 2,
                               .scale = 1,
                               .weight = 1,
                               .grid = {.width = 2, .height = 1},
                               .costs = s.t.costs,
                               .pairwise = {.smoothness = QS_TABLES},
                               .table_source = {put_tables, &s}};
    const qs_problem *p = &s.t.problem;
    s.tables[0][1] = -1;
    qs_encode_options options = {0};
    assert_int_equal(qs_problem_check(p), QS_OK);
    assert_int_equal(qs_problem_energy(p, labelling, memory, sizeof memory, &energy),
                     QS_E_ARGUMENT);
    assert_int_equal(qs_encode(p, &options, NULL, memory, sizeof memory, NULL), QS_E_ARGUMENT);
    assert_int_equal(qs_model_of_problem(p, model_memory, sizeof model_memory, &model, NULL),
                     QS_E_ARGUMENT);
    options.encoding = QS_DOMAIN_WALL;
    s.tables[0][1] = 4;
    assert_int_equal(qs_encode(p, &options, NULL, memory, sizeof memory, NULL), QS_E_ENCODING);
    assert_int_equal(qs_problem_energy(p, labelling, memory, sizeof memory, &energy), QS_OK);
    assert_int_equal(energy, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_in_files),
        cmocka_unit_test(forbidden_labels_in_files),
        cmocka_unit_test(tables_of_walls_are_not_too_large),
        cmocka_unit_test(solvers_take_tables_and_sets),
        cmocka_unit_test(reductions_keep_the_optimum),
        cmocka_unit_test(largest_energy),
        cmocka_unit_test(refusals),
        cmocka_unit_test(made_tables_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
