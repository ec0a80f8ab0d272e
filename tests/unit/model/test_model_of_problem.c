/* The model of a problem in memory beside the model of its file. */
#include "tiny.h"

#include <string.h>

enum { ROUNDS = 3000, BITS = 24, MEMORY = 1 << 15 };

static tiny t;
static tiny_qubo q;
static uint64_t file_memory[MEMORY / 8], problem_memory[MEMORY / 8];
static qs_model of_file, of_problem;
static qs_labels labels;

static void same_bytes(const void *a, const void *b, size_t size)
{
    assert_true((a == NULL) == (b == NULL));
    if (a != NULL) {
        assert_int_equal(memcmp(a, b, size), 0);
    }
}

static void same_graph(void)
{
    size_t sites = of_file.sites;
    if (of_file.width > 0) {
        same_bytes(of_problem.right, of_file.right, sites * sizeof *of_file.right);
        same_bytes(of_problem.down, of_file.down, sites * sizeof *of_file.down);
        return;
    }
    assert_int_equal(of_problem.edges, of_file.edges);
    same_bytes(of_problem.link_start, of_file.link_start, (sites + 1) * sizeof *of_file.link_start);
    for (uint32_t n = 0; n < of_file.link_start[sites]; n++) {
        assert_int_equal(of_problem.links[n].site, of_file.links[n].site);
        assert_int_equal(of_problem.links[n].edge, of_file.links[n].edge);
        assert_int_equal(of_problem.links[n].weight, of_file.links[n].weight);
    }
}

static void same_models(void)
{
    size_t count = of_file.labels;
    assert_int_equal(of_problem.sites, of_file.sites);
    assert_int_equal(of_problem.labels, of_file.labels);
    assert_int_equal(of_problem.constant, of_file.constant);
    same_bytes(of_problem.unary, of_file.unary, of_file.sites * count * sizeof *of_file.unary);
    assert_null(of_problem.kept);
    assert_null(of_file.kept);
    assert_int_equal(of_problem.pairwise.smoothness, of_file.pairwise.smoothness);
    assert_int_equal(of_problem.pairwise.truncation, of_file.pairwise.truncation);
    same_bytes(of_problem.pairwise.table, of_file.pairwise.table,
               count * count * sizeof *of_file.pairwise.table);
    assert_int_equal(of_problem.pairwise_max, of_file.pairwise_max);
    assert_int_equal(of_problem.width, of_file.width);
    assert_int_equal(of_problem.height, of_file.height);
    same_bytes(of_problem.mask, of_file.mask, (of_file.sites + 7) / 8);
    same_graph();
}

static void same_labels(const qs_labels *a, const qs_labels *b)
{
    assert_int_equal(a->encoding, b->encoding);
    assert_int_equal(a->pairwise.smoothness, b->pairwise.smoothness);
    assert_int_equal(a->pairwise.truncation, b->pairwise.truncation);
    assert_null(a->pairwise.table);
    assert_int_equal(a->penalty, b->penalty);
    assert_int_equal(a->labels, b->labels);
    assert_int_equal(a->scale, b->scale);
    assert_int_equal(a->gap, b->gap);
    assert_int_equal(a->weight, b->weight);
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    same_bytes(&a->frame, &b->frame, sizeof a->frame);
    same_bytes(a->mask, b->mask, ((size_t)a->width * a->height + 7) / 8);
    assert_int_equal(a->sites, b->sites);
    assert_int_equal(a->undecided, b->undecided);
    assert_int_equal(a->fixed_bytes, b->fixed_bytes);
    assert_int_equal(a->trimmed_bytes, b->trimmed_bytes);
}

static size_t recode(const qs_model *model, const qs_labels *said, uint8_t file[TINY_FILE])
{
    static uint64_t memory[MEMORY / 8];
    const qs_recode_options options = {.encode.encoding = QS_ONE_HOT};
    qs_buffer buffer = {file, TINY_FILE, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_true(qs_recode_workspace(model, &options) <= sizeof memory);
    assert_int_equal(qs_recode(model, said, &options, &sink, memory, sizeof memory, NULL), QS_OK);
    return buffer.size;
}

/* Written again, the model of the problem gives the same bytes as that of the file. */
static void same_files(void)
{
    static uint8_t a[TINY_FILE], b[TINY_FILE];
    size_t size = recode(&of_file, &q.qubo.labels, a);
    assert_int_equal(recode(&of_problem, &labels, b), size);
    assert_memory_equal(a, b, size);
}

static void both_ways(const qs_problem *problem)
{
    tiny_encode(problem, (qs_encode_options){.encoding = QS_ONE_HOT}, &q);
    size_t size = qs_model_workspace(&q.qubo);
    assert_true(size <= sizeof file_memory);
    assert_int_equal(qs_model_build(&q.index, file_memory, size, &of_file), QS_OK);
    size = qs_model_of_problem_workspace(problem);
    assert_true(size <= sizeof problem_memory);
    memset(problem_memory, 0xa5, sizeof problem_memory);
    assert_int_equal(qs_model_of_problem(problem, problem_memory, size, &of_problem, &labels),
                     QS_OK);
    same_models();
    same_labels(&labels, &q.qubo.labels);
    same_files();
}

/* The costs of `t` made row by row, in bytes or in words. */
static void make_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    const qs_problem *problem = &t.problem;
    uint32_t width = problem->grid.width, count = problem->labels, site = 0;
    bool bytes = *(unsigned *)context == 1;
    for (uint32_t cell = 0; cell < row * width; cell++) {
        site += !problem->grid.mask || problem->grid.mask[cell] != 0;
    }
    for (uint32_t x = 0; x < width; x++) {
        bool is_site = !problem->grid.mask || problem->grid.mask[row * width + x] != 0;
        const int32_t *own = t.costs + (size_t)site * count;
        least[x] = own[0];
        for (uint32_t d = 1; d < count; d++) {
            least[x] = own[d] < least[x] ? own[d] : least[x];
        }
        for (uint32_t d = 0; d < count; d++) {
            /* A masked cell has costs, too, and nobody may look at them. */
            uint32_t cost = is_site ? (uint32_t)(own[d] - least[x]) : 99;
            if (bytes) {
                ((uint8_t *)costs)[x * count + d] = (uint8_t)cost;
            } else {
                ((uint32_t *)costs)[x * count + d] = cost;
            }
        }
        least[x] = is_site ? least[x] : -7;
        site += is_site;
    }
}

static void as_the_model_of_the_file(void **unused)
{
    (void)unused;
    uint64_t state = 71;
    uint32_t made = 0;
    for (int round = 0; round < ROUNDS; round++) {
        tiny_make(&t, &state, BITS, round % 3 == 0);
        if (t.problem.edge_count > 1 && t.problem.edge_count < TINY_EDGES && round % 2 == 0) {
            /* Edges in no order, one of them twice, with another weight. */
            qs_edge first = t.edges[0];
            t.edges[0] = t.edges[t.problem.edge_count - 1];
            t.edges[t.problem.edge_count - 1] = first;
            first.weight++;
            t.edges[t.problem.edge_count++] = first;
        }
        both_ways(&t.problem);
        unsigned bytes = round % 2 == 0 ? 1 : 4;
        if (t.problem.grid.width > 0) {
            qs_problem problem = t.problem;
            problem.costs = NULL;
            problem.source = (qs_cost_source){make_row, &bytes, (uint8_t)bytes, 0, 0, NULL};
            both_ways(&problem);
            made++;
        }
    }
    assert_true(made > ROUNDS / 2);
}

static void frames_and_weights_of_labels(void **unused)
{
    (void)unused;
    int32_t costs[8] = {0, 1, 2, 3, 4, 5, 6, 7}, right[4] = {2, 9, 2, 9}, down[4] = {2, 2, 9, 9};
    uint8_t mask[4] = {1, 1, 1, 1};
    qs_problem problem = {.labels = 2,
                          .scale = 10,
                          .weight = 5,
                          .grid = {.width = 2, .height = 2, .mask = mask},
                          .costs = costs,
                          .frame = {30, 20, 7, 8, 3}};
    both_ways(&problem);
    assert_int_equal(labels.weight, 5);
    assert_int_equal(labels.frame.first, 3);
    assert_null(labels.mask);
    problem.grid.right = right;
    problem.grid.down = down;
    both_ways(&problem);
    assert_int_equal(labels.weight, 2);
    down[1] = 3;
    both_ways(&problem);
    assert_int_equal(labels.weight, -1);
}

static qs_status try_problem(const qs_problem *problem)
{
    return qs_model_of_problem(problem, problem_memory, sizeof problem_memory, &of_problem, NULL);
}

static void refusals(void **unused)
{
    (void)unused;
    int32_t costs[4] = {0, INT32_MAX, 5, 6}, table[4] = {0, 1, 1, 0};
    qs_edge edge = {0, 1, 1};
    qs_problem problem = {.sites = 2,
                          .labels = 2,
                          .scale = 1,
                          .edges = &edge,
                          .edge_count = 1,
                          .costs = costs,
                          .pairwise = {QS_TABLE, 0, table}};
    assert_int_equal(try_problem(&problem), QS_OK);
    qs_model unchanged = of_problem;
    size_t size = qs_model_of_problem_workspace(&problem);
    assert_int_equal(qs_model_of_problem(&problem, problem_memory, size - 1, &of_problem, NULL),
                     QS_E_WORKSPACE);
    assert_int_equal(qs_model_of_problem(&problem, NULL, size, &of_problem, NULL), QS_E_ARGUMENT);
    assert_int_equal(qs_model_of_problem(&problem, problem_memory, size, NULL, NULL),
                     QS_E_ARGUMENT);
    assert_int_equal(qs_model_of_problem(NULL, problem_memory, size, &of_problem, NULL),
                     QS_E_ARGUMENT);
    costs[0] = -1; /* less the least of its site the other cost is 2^31 */
    assert_int_equal(try_problem(&problem), QS_E_OVERFLOW);
    costs[0] = 0;
    table[1] = -1;
    assert_int_equal(try_problem(&problem), QS_E_ARGUMENT);
    table[1] = INT32_MAX; /* one edge of the largest weight and cost is above 2^60 */
    edge.weight = INT32_MAX;
    assert_int_equal(try_problem(&problem), QS_E_OVERFLOW);
    edge.weight = 1 << 28;
    assert_int_equal(try_problem(&problem), QS_OK);
    of_problem = unchanged;
    edge.second = 2;
    assert_int_equal(try_problem(&problem), QS_E_ARGUMENT);
    assert_memory_equal(&of_problem, &unchanged, sizeof unchanged);
}

/* (65534)^2 does not fit 31 bits. */
static void pairwise_costs_that_do_not_fit(void **unused)
{
    (void)unused;
    static int32_t costs[QS_LABELS_MAX];
    static uint64_t memory[QS_LABELS_MAX + 64];
    qs_problem problem = {.sites = 1,
                          .labels = QS_LABELS_MAX,
                          .scale = 1,
                          .costs = costs,
                          .pairwise = {QS_TRUNCATED_QUADRATIC, 0, NULL}};
    assert_true(qs_model_of_problem_workspace(&problem) <= sizeof memory);
    assert_int_equal(qs_model_of_problem(&problem, memory, sizeof memory, &of_problem, NULL),
                     QS_E_OVERFLOW);
    problem.pairwise.truncation = 1000;
    assert_int_equal(qs_model_of_problem(&problem, memory, sizeof memory, &of_problem, NULL),
                     QS_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_the_model_of_the_file),
        cmocka_unit_test(frames_and_weights_of_labels),
        cmocka_unit_test(refusals),
        cmocka_unit_test(pairwise_costs_that_do_not_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
