/* Certificates against all labellings of tiny problems: those that solvers write hold, and none
 * that holds, whoever has written it, states what is not so. */
#include "solve/messages.h" /* first: its parameters have the name of a variable of modelled.h */

#include "modelled.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "certificate/certificate_layout.h"
#include "certificate/record_book.h"
#include "files/crc32c.h"
#include "model/convexity.h"
#include "solve/pack.h"

enum { FILE_SIZE = 1 << 18, COUNT_AT = 28, BOUND_AT = 32, ENERGY_AT = 40, HEADER = 64 };

/* A certificate, and what it is of. */
typedef struct certified {
    uint8_t stages[FILE_SIZE], file[FILE_SIZE], left[TINY_SITES * TINY_LABELS];
    size_t size;
    qs_verdict verdict;
    uint16_t labelling[TINY_SITES]; /* of the problem's sites */
    uint8_t kept[TINY_SITES * TINY_LABELS]; /* as the reduction says */
    int64_t energy, bound;
} certified;

static certified c;
static uint64_t workspace[1 << 17];

/* What the file says of the labels of its sites. */
static bool is_left(uint32_t site, uint32_t label)
{
    return request.kept[site][label];
}

static uint32_t left_count(uint32_t site)
{
    uint32_t count = 0;
    for (uint32_t d = 0; d < t.problem.labels; d++) {
        count += is_left(site, d);
    }
    return count;
}

static uint32_t site_count(void)
{
    return qs_problem_sites(&t.problem);
}

/* The file of the whole problem, as the library writes it. */
static void encode_whole(qs_encoding encoding)
{
    static uint64_t memory[1 << 14];
    qs_encode_options options = {.encoding = encoding, .gap = 1};
    qs_buffer buffer = {written.file, sizeof written.file, 0};
    qs_sink sink = qs_buffer_sink(&buffer);
    assert_true(qs_encode_workspace(&t.problem) <= sizeof memory);
    assert_int_equal(
        qs_encode(&t.problem, &options, &sink, memory, qs_encode_workspace(&t.problem), NULL),
        QS_OK);
    written.size = buffer.size;
    slow_open(&written);
    request = (slow_request){.problem = &t.problem, .encoding = encoding, .gap = 1};
    memset(request.kept, 1, sizeof request.kept);
    assert_int_equal(
        qs_model_build(&written.index, model_memory, qs_model_workspace(&written.qubo), &model),
        QS_OK);
}

typedef struct block {
    uint8_t *bytes;
    size_t size;
} block;

/* Memory of that very size, the end of a block: the sanitizer sees a byte too many. To ask for
 * each anew would take most of the time, as some are large. */
static void *end_of(block *b, size_t size)
{
    assert_int_equal(size % 8, 0);
    if (size > b->size) {
        free(b->bytes);
        *b = (block){malloc(size), size};
        assert_non_null(b->bytes);
    }
    return b->bytes + (b->size - size);
}

/* ---- Checking. ---- */

static qs_status check(void)
{
    qs_certificate view;
    qs_status status = qs_certificate_open(c.file, c.size, &view, NULL);
    if (status != QS_OK) {
        return status;
    }
    size_t size = qs_certificate_workspace(&written.index);
    qs_fault fault = {0, NULL};
    static block memory;
    status = qs_certificate_check(&written.index, &view, end_of(&memory, size), size, &c.verdict,
                                  c.left, &fault);
    assert_true(status == QS_OK || fault.what);
    return status;
}

/* The least F, and whether every labelling that has it is left by the certificate. */
static void assert_true_of_all_labellings(int64_t stated)
{
    uint16_t w[TINY_SITES];
    int64_t least = INT64_MAX;
    slow_first(&request, w);
    do {
        int64_t energy = slow_energy(&t.problem, w);
        least = energy < least ? energy : least;
    } while (slow_next(&request, w));
    assert_true(c.verdict.lower_bound <= least);
    assert_true(stated <= least);
    slow_first(&request, w);
    do {
        size_t at = 0;
        for (uint32_t p = 0; p < site_count() && slow_energy(&t.problem, w) == least; p++) {
            for (uint32_t d = 0; left_count(p) > 1 && d < t.problem.labels; d++) {
                if (is_left(p, d)) {
                    assert_true(c.left[at++] || w[p] != d);
                }
            }
        }
    } while (slow_next(&request, w));
}

/* ---- Making. ---- */

static void write_file(const qs_recorder *recorder, const qs_buffer *stages, int64_t bound)
{
    qs_buffer file = {c.file, sizeof c.file, 0};
    qs_sink sink = qs_buffer_sink(&file);
    uint64_t size = 0;
    assert_int_equal(qs_certificate_write(recorder, c.labelling, bound, c.energy, stages->bytes,
                                          stages->size, &sink, &size),
                     QS_OK);
    assert_int_equal(size, file.size);
    c.size = file.size;
}

typedef qs_status made_by(const qs_witness *witness, uint64_t iterations);

typedef qs_status solver(const qs_model *model, const qs_solve_options *options, void *workspace,
                         size_t workspace_size, uint16_t *labelling, qs_solution *solution);

static qs_status by_solver(solver *solve, const qs_witness *witness, uint64_t iterations)
{
    qs_solution solution;
    qs_solve_options options = {.iterations = iterations, .witness = witness};
    qs_status status = solve(&model, &options, workspace, sizeof workspace, c.labelling, &solution);
    c.energy = solution.energy;
    c.bound = solution.lower_bound;
    return status;
}

static qs_status by_trws(const qs_witness *witness, uint64_t iterations)
{
    return by_solver(qs_trws, witness, iterations);
}

static qs_status by_best(const qs_witness *witness, uint64_t iterations)
{
    return by_solver(qs_best, witness, iterations);
}

static qs_status by_cut(const qs_witness *witness, uint64_t iterations)
{
    (void)iterations;
    qs_model_winner(&model, c.labelling);
    return by_solver(qs_min_cut, witness, 0);
}

static qs_status by_reduce(const qs_witness *witness, uint64_t iterations)
{
    qs_reduction reduction;
    qs_reduce_options options = {.iterations = iterations, .witness = witness};
    qs_status status =
        qs_reduce(&model, &options, workspace, sizeof workspace, c.kept, c.labelling, &reduction);
    c.energy = reduction.upper_bound;
    c.bound = reduction.lower_bound;
    return status;
}

static bool is_too_wide(void *context, const uint32_t *sites, uint32_t count, bool labels)
{
    (void)context;
    (void)sites;
    (void)count;
    (void)labels;
    return false;
}

/* No part is solved, so that labels are tried when messages get no further. */
static qs_status by_trials(const qs_witness *witness, uint64_t iterations)
{
    qs_witness refuses = *witness;
    refuses.part = is_too_wide;
    return by_reduce(&refuses, 300 + iterations);
}

/* All sites that are undecided as one part, whose edges lead nowhere else. The labelling is not the
 * best: what is proven is a bound. */
static qs_status by_one_part(const qs_witness *witness, bool labels)
{
    int site[TINY_SITES];
    uint32_t part[TINY_SITES], count = 0;
    sites_of_model(site);
    for (uint32_t p = 0; p < model.sites; p++) {
        if (site[p] >= 0 && left_count((uint32_t)site[p]) > 1) {
            part[count++] = p;
        }
    }
    qs_model_winner(&model, c.labelling);
    c.energy = qs_model_energy(&model, c.labelling);
    assert_true(witness->part(witness->context, part, count, labels));
    assert_false(witness->part(witness->context, part, count, labels)); /* it is settled */
    return QS_OK;
}

static qs_status by_part(const qs_witness *witness, uint64_t iterations)
{
    (void)iterations;
    return by_one_part(witness, true);
}

/* Tables have used up what they may have. */
static qs_status by_search(const qs_witness *witness, uint64_t iterations)
{
    const qs_recorder *recorder = witness->context;
    (void)iterations;
    recorder->book->exact_cells = QS_EXACT_ALL_CELLS;
    return by_one_part(witness, false);
}

/* Makes the certificate of the model. Returns false if the solver cannot write one. */
static bool certify(made_by *make, uint64_t iterations)
{
    qs_recorder recorder;
    qs_buffer stages = {c.stages, sizeof c.stages, 0};
    qs_sink sink = qs_buffer_sink(&stages);
    size_t size = qs_recorder_workspace(&written.index, &model);
    static block memory;
    qs_status status =
        qs_recorder_begin(&recorder, &written.index, &model, end_of(&memory, size), size, &sink);
    if (status == QS_OK) {
        qs_witness witness = qs_recorder_witness(&recorder);
        status = make(&witness, iterations);
    }
    if (status == QS_OK) {
        status = qs_recorder_end(&recorder);
    }
    if (status == QS_OK) {
        qs_model_sites(&model, c.labelling, c.labelling);
        write_file(&recorder, &stages, QS_NO_BOUND);
        assert_int_equal(check(), QS_OK);
        assert_null(c.verdict.why);
        write_file(&recorder, &stages, c.verdict.lower_bound);
    }
    assert_true(status == QS_OK || status == QS_E_ENCODING || status == QS_E_OVERFLOW);
    return status == QS_OK;
}

static const qs_encoding encodings[] = {QS_ONE_HOT, QS_ONE_HOT_SPARSE, QS_DOMAIN_WALL};

static void each_certificate(made_by *make, uint64_t seed, void (*look)(uint64_t *state))
{
    uint64_t state = seed;
    int written_ones = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make_reduced(&state, encodings[round % 3]);
        if (written.qubo.groups > 0 && certify(make, 1 + tiny_random(&state, 12))) {
            written_ones++;
            look(&state);
        }
    }
    assert_true(written_ones > ROUNDS / 4);
}

/* ---- Those of the solvers hold. ---- */

static int lower; /* bounds below the solver's */

static void holds(uint64_t *state)
{
    (void)state;
    assert_int_equal(check(), QS_OK);
    assert_true(c.verdict.valid);
    assert_int_equal(c.verdict.energy, c.energy);
    lower += c.verdict.lower_bound < c.bound;
    assert_true_of_all_labellings(c.verdict.lower_bound);
}

static void bounds_hold(void **unused)
{
    (void)unused;
    lower = 0;
    each_certificate(by_trws, 1, holds);
    each_certificate(by_best, 2, holds);
    assert_true(lower < ROUNDS / 20); /* the last pass is not always the best */
}

/* A flow proves the optimum itself. */
static void proves_the_optimum(uint64_t *state)
{
    holds(state);
    assert_int_equal(c.energy, c.bound);
    assert_int_equal(c.verdict.lower_bound, c.energy);
}

static void cuts_prove_the_optimum(void **unused)
{
    (void)unused;
    each_certificate(by_cut, 7, proves_the_optimum);
}

/* Convex costs of sites and edges, of which descent makes no graph of levels. */
static void make_convex(uint64_t *state)
{
    do {
        tiny_make(&t, state, BITS, false);
    } while (t.problem.labels < 3);
    t.problem.pairwise.smoothness =
        tiny_random(state, 2) ? QS_TRUNCATED_LINEAR : QS_TRUNCATED_QUADRATIC;
    t.problem.pairwise.truncation = 0;
    for (uint32_t p = 0; p < site_count(); p++) {
        int32_t slope = (int32_t)tiny_random(state, 40) - 60, cost = 200;
        for (uint32_t a = 0; a < t.problem.labels; a++) {
            t.costs[p * t.problem.labels + a] = cost;
            cost += slope;
            slope += (int32_t)tiny_random(state, 40);
        }
    }
    request = (slow_request){.problem = &t.problem, .encoding = QS_ONE_HOT, .gap = 1};
    for (uint32_t p = 0; p < TINY_SITES; p++) { /* without gaps */
        uint32_t first = tiny_random(state, t.problem.labels);
        for (uint32_t d = 0; d < t.problem.labels; d++) {
            request.kept[p][d] = p % 3 > 0 || d >= first;
        }
    }
    slow_encode(&request, &written);
    assert_int_equal(
        qs_model_build(&written.index, model_memory, qs_model_workspace(&written.qubo), &model),
        QS_OK);
}

static void descents_prove_the_optimum(void **unused)
{
    (void)unused;
    uint64_t state = 9;
    int descents = 0;
    for (int round = 0; round < ROUNDS; round++) {
        make_convex(&state);
        if (written.qubo.groups > 0) {
            assert_true(certify(by_cut, 0));
            proves_the_optimum(&state);
            descents += qs_unary_is_convex(&model);
        }
    }
    assert_true(descents > ROUNDS / 2);
}

/* Opposite corners that pull apart with nearly all that a cost can be: no smaller charge than PULL
 * proves that the edges hold them together. */
static void a_large_descent_proves_the_optimum(void **unused)
{
    (void)unused;
    enum { PULL = INT32_MAX / 2 };
    const int32_t costs[] = {0, PULL, 2 * PULL, 0, 0, 0, 0, 0, 0, 2 * PULL, PULL, 0};
    memcpy(t.costs, costs, sizeof costs);
    t.problem = (qs_problem){.labels = 3,
                             .scale = 1,
                             .weight = PULL + 1,
                             .pairwise = {.smoothness = QS_TRUNCATED_LINEAR},
                             .grid = {.width = 2, .height = 2},
                             .costs = t.costs};
    encode_whole(QS_ONE_HOT);
    uint64_t state = 0;
    assert_true(certify(by_cut, 0));
    proves_the_optimum(&state);
}

/* Two labels, and for each edge a table of its own that a cut can hold. */
static void make_submodular_tables(uint64_t *state)
{
    static int32_t tables[4 * TINY_EDGES];
    do {
        tiny_make(&t, state, BITS, true);
    } while (t.problem.labels != 2 || t.problem.edge_count < 3);
    for (size_t i = 0; i < 4 * t.problem.edge_count; i++) {
        tables[i] = (int32_t)tiny_random(state, 9) + (i % 4 == 1 || i % 4 == 2 ? 8 : 0);
    }
    t.problem.pairwise.smoothness = QS_TABLES;
    t.problem.tables = tables;
    encode_whole(QS_ONE_HOT);
}

static void cuts_of_tables_prove_the_optimum(void **unused)
{
    (void)unused;
    uint64_t state = 18;
    for (int round = 0; round < ROUNDS / 4; round++) {
        make_submodular_tables(&state);
        assert_true(certify(by_cut, 0));
        proves_the_optimum(&state);
    }
}

/* The certificate leaves exactly what the reduction does. */
static void leaves_as_reduced(uint64_t *state)
{
    int site[TINY_SITES];
    size_t at = 0;
    holds(state);
    sites_of_model(site);
    for (uint32_t p = 0; p < model.sites; p++) {
        uint32_t count = site[p] >= 0 ? left_count((uint32_t)site[p]) : 0;
        for (uint32_t d = 0; count > 1 && d < t.problem.labels; d++) {
            if (is_left((uint32_t)site[p], d)) {
                assert_int_equal(c.left[at++], c.kept[p * t.problem.labels + d]);
            }
        }
    }
    assert_true(qs_certificate_covers(&written.qubo, c.left, &written.qubo));
}

/* Costs so large that messages take 64 bits, and that some do not fold into others. */
static void make_large(uint64_t *state)
{
    enum { LARGE = 100000000 };
    do {
        tiny_make(&t, state, BITS / 2, false);
        t.problem.weight = LARGE * (1 + (int32_t)tiny_random(state, 8));
        for (uint32_t i = 0; i < TINY_SITES; i++) {
            t.right[i] = LARGE * (int32_t)tiny_random(state, 8);
            t.down[i] = LARGE * (int32_t)tiny_random(state, 8);
        }
        for (size_t e = 0; e < t.problem.edge_count; e++) {
            t.edges[e].weight *= LARGE;
        }
        for (uint32_t i = 0; i < TINY_SITES * TINY_LABELS; i++) {
            t.costs[i] = (int32_t)tiny_random(state, 20 * LARGE);
        }
        encode_whole(QS_ONE_HOT);
    } while (written.qubo.groups == 0 || qs_messages_fit(&model, true));
}

static void large_costs_have_certificates(void **unused)
{
    (void)unused;
    made_by *const makers[] = {by_trws, by_best, by_reduce};
    uint64_t state = 28;
    lower = 0;
    for (int round = 0; round < ROUNDS / 2; round++) {
        make_large(&state);
        made_by *make = makers[round % 3];
        assert_true(certify(make, 1 + tiny_random(&state, 12)));
        make == by_reduce ? leaves_as_reduced(&state) : holds(&state);
    }
    assert_true(lower < ROUNDS / 20);
}

static void reductions_hold(void **unused)
{
    (void)unused;
    each_certificate(by_reduce, 3, leaves_as_reduced);
}

/* Two labels and costs of equal ones, in triangles: the relaxation says much less than what is
 * true.
 *
 * one_in  of so many edges one stays */
static void make_frustrated(uint64_t *state, uint32_t one_in)
{
    do {
        tiny_make(&t, state, BITS, true);
    } while (t.problem.labels != 2 || !t.problem.edges || t.problem.edge_count < 12);
    t.problem.pairwise.smoothness = QS_TABLE;
    t.problem.pairwise.table = t.table;
    for (uint32_t i = 0; i < 4; i++) {
        t.table[i] = i % 3 == 0;
    }
    for (uint32_t i = 0; i < t.problem.edge_count; i++) {
        bool is_there = tiny_random(state, one_in) == 0;
        t.edges[i].weight = is_there ? 20 + (int32_t)tiny_random(state, 20) : 0;
    }
    for (uint32_t i = 0; i < 2 * t.problem.sites; i++) {
        t.costs[i] = (int32_t)tiny_random(state, 60);
    }
    request = (slow_request){.problem = &t.problem, .encoding = QS_ONE_HOT, .gap = 1};
    memset(request.kept, 1, sizeof request.kept);
    slow_encode(&request, &written);
    assert_int_equal(
        qs_model_build(&written.index, model_memory, qs_model_workspace(&written.qubo), &model),
        QS_OK);
}

static void trials_hold(void **unused)
{
    (void)unused;
    uint64_t state = 14;
    int open_ones = 0, missed = 0;
    for (int round = 0; round < ROUNDS / 4; round++) {
        make_frustrated(&state, 2); /* so that few triangles share edges */
        assert_true(certify(by_trials, 0));
        leaves_as_reduced(&state);
        open_ones += c.verdict.lower_bound < c.energy;
        missed += c.energy > tiny_minimum(&t.problem);
    }
    assert_int_equal(missed, 0);
    assert_true(open_ones < ROUNDS / 40); /* without trials it is more than half */
}

static uint64_t iterations_done;

static bool note_iterations(void *context, const qs_reduction *so_far)
{
    (void)context;
    iterations_done = so_far->iterations;
    return true;
}

/* With the limit of its own, and parts that nobody solves. */
static qs_status by_reduce_alone(const qs_witness *witness, uint64_t iterations)
{
    qs_witness refuses = *witness;
    qs_reduction reduction;
    qs_reduce_options options = {.witness = &refuses, .watch = note_iterations};
    (void)iterations;
    refuses.part = is_too_wide;
    qs_status status =
        qs_reduce(&model, &options, workspace, sizeof workspace, c.kept, c.labelling, &reduction);
    c.energy = reduction.upper_bound;
    c.bound = reduction.lower_bound;
    return status;
}

/* Where nothing helps, a reduction ends long before its limit; what it says is proven all the
 * same. */
static void ends_when_nothing_is_gained(void **unused)
{
    (void)unused;
    uint64_t state = 15;
    int open_ones = 0;
    for (int round = 0; round < ROUNDS / 16; round++) {
        make_frustrated(&state, 1);
        assert_true(certify(by_reduce_alone, 0));
        leaves_as_reduced(&state);
        open_ones += c.verdict.lower_bound < c.energy;
        assert_true(iterations_done <= 1100);
    }
    assert_true(open_ones > ROUNDS / 64);
}

/* Costs of pairs kept: best packs them, and a witness is told of messages. */
static void packed_ones_have_certificates(void **unused)
{
    (void)unused;
    uint64_t state = 16;
    for (int round = 0; round < ROUNDS / 16; round++) {
        make_frustrated(&state, 2);
        t.table[0] = 0;
        slow_encode(&request, &written);
        assert_int_equal(
            qs_model_build(&written.index, model_memory, qs_model_workspace(&written.qubo), &model),
            QS_OK);
        assert_true(qs_can_pack(&model));
        assert_true(certify(by_best, 0));
        holds(&state);
        assert_int_equal(c.energy, tiny_minimum(&t.problem));
    }
}

/* Of a label of a site that is left: is it in a labelling that costs as much? */
static bool is_in_one_of(int64_t energy, uint32_t site, uint32_t label)
{
    uint16_t w[TINY_SITES];
    bool found = false;
    slow_first(&request, w);
    do {
        found = found || (w[site] == label && slow_energy(&t.problem, w) == energy);
    } while (slow_next(&request, w));
    return found;
}

static bool is_the_least(int64_t energy)
{
    bool found = false;
    for (uint32_t d = 0; d < t.problem.labels; d++) {
        found = found || is_in_one_of(energy, 0, d);
    }
    return found; /* `holds` has seen that none is lower */
}

/* The bound is the optimum, and exactly the labels of optima are left. */
static void is_solved(uint64_t *state)
{
    holds(state);
    uint32_t undecided = 0;
    uint64_t labels = 0;
    size_t at = 0;
    for (uint32_t p = 0; p < site_count(); p++) {
        uint32_t stay = 0;
        for (uint32_t d = 0; left_count(p) > 1 && d < t.problem.labels; d++) {
            if (is_left(p, d)) {
                assert_int_equal(c.left[at], is_in_one_of(c.verdict.lower_bound, p, d));
                stay += c.left[at++];
            }
        }
        undecided += stay > 1;
        labels += stay > 1 ? stay : 0;
    }
    assert_int_equal(c.verdict.undecided, undecided);
    assert_int_equal(c.verdict.labels, labels);
}

static void parts_are_solved(void **unused)
{
    (void)unused;
    each_certificate(by_part, 10, is_solved);
}

/* The bound is the optimum, and all labels are left. */
static void is_searched(uint64_t *state)
{
    uint32_t labels = 0;
    holds(state);
    assert_true(is_the_least(c.verdict.lower_bound));
    for (uint32_t p = 0; p < site_count(); p++) {
        labels += left_count(p) > 1 ? left_count(p) : 0;
    }
    assert_int_equal(c.verdict.labels, labels);
}

static void parts_are_searched(void **unused)
{
    (void)unused;
    each_certificate(by_search, 19, is_searched);
}

/* A reduced problem that lacks a label which is left is not covered. */
static void lacks_a_label(uint64_t *state)
{
    static slow_qubo smaller;
    slow_request fewer = request;
    memset(c.left, 1, sizeof c.left);
    for (uint32_t p = 0; p < site_count(); p++) {
        uint32_t label = 0;
        for (uint32_t d = 0; d < t.problem.labels; d++) {
            label = is_left(p, d) ? d : label;
        }
        if (left_count(p) > 1) {
            fewer.kept[p][label] = false;
            slow_encode(&fewer, &smaller);
            assert_false(qs_certificate_covers(&written.qubo, c.left, &smaller.qubo));
            return;
        }
    }
    (void)state;
}

static void reduced_problems_are_compared(void **unused)
{
    (void)unused;
    each_certificate(by_reduce, 4, lacks_a_label);
}

/* ---- Those of others. ---- */

static void mend(void)
{
    qs_store_u32(c.file + 60, qs_crc32c_portable(0, c.file, 60));
    for (size_t at = HEADER; at + 20 <= c.size;) {
        size_t covered = 16 + (size_t)qs_load_u64(c.file + at + 8);
        qs_store_u32(c.file + at + covered, qs_crc32c_portable(0, c.file + at, covered));
        at += covered + 4;
    }
}

static void add_to(size_t at, int64_t more)
{
    qs_store_u64(c.file + at, qs_load_u64(c.file + at) + (uint64_t)more);
    mend();
    assert_int_equal(check(), QS_OK);
}

/* A bound that is raised by one, and an energy that is not the labelling's. */
static void states_too_much(uint64_t *state)
{
    (void)state;
    assert_true(c.verdict.lower_bound != QS_NO_BOUND);
    add_to(BOUND_AT, 1);
    assert_false(c.verdict.valid);
    assert_non_null(c.verdict.why);
    add_to(BOUND_AT, -1);
    assert_true(c.verdict.valid);
    add_to(BOUND_AT, -1);
    assert_true(c.verdict.valid);
    add_to(ENERGY_AT, 1);
    assert_false(c.verdict.valid);
    add_to(ENERGY_AT, -2);
    assert_false(c.verdict.valid);
}

static void too_much_is_refuted(void **unused)
{
    (void)unused;
    each_certificate(by_trws, 5, states_too_much);
    each_certificate(by_cut, 11, states_too_much);
    each_certificate(by_part, 12, states_too_much);
    each_certificate(by_search, 21, states_too_much);
}

static int valid, refuted, malformed;

/* Checks the file as it is now: what holds is true. */
static void note_what_is_true(void)
{
    qs_status status = check();
    malformed += status != QS_OK;
    refuted += status == QS_OK && !c.verdict.valid;
    valid += status == QS_OK && c.verdict.valid;
    if (status == QS_OK && c.verdict.valid) {
        assert_true_of_all_labellings((int64_t)qs_load_u64(c.file + BOUND_AT));
    }
}

/* Bytes changed at random, CRCs mended: what still holds is true. */
static void stays_true(uint64_t *state)
{
    static uint8_t whole[FILE_SIZE];
    size_t begin = HEADER + 20 + QS_DIGEST_SIZE;
    memcpy(whole, c.file, c.size);
    for (int i = 0; i < 8; i++) {
        memcpy(c.file, whole, c.size);
        for (uint32_t n = 1 + tiny_random(state, 3); n > 0; n--) {
            size_t at = begin + tiny_random(state, (uint32_t)(c.size - begin));
            c.file[at] =
                (uint8_t)(tiny_random(state, 2) ? tiny_random(state, 256)
                                                : c.file[at] ^ 1u << tiny_random(state, 8));
        }
        /* Chunks keep their frames. */
        memcpy(c.file + begin, whole + begin, 20);
        size_t best = (size_t)qs_load_u64(whole + begin + 8);
        memcpy(c.file + begin + 20 + best, whole + begin + 20 + best, 16);
        mend();
        note_what_is_true();
    }
}

static void no_certificate_lies(void **unused)
{
    (void)unused;
    made_by *const makers[] = {by_reduce, by_trws, by_cut, by_part, by_search};
    for (uint64_t i = 0; i < sizeof makers / sizeof makers[0]; i++) {
        valid = refuted = malformed = 0;
        each_certificate(makers[i], 6 + i, stays_true);
        assert_true(valid > 10 && refuted > 10 && malformed > 10);
    }
}

/* Every bit of the labelling and of the stages of one file, CRCs mended. */
static void stays_true_bit_by_bit(made_by *make, uint64_t seed)
{
    uint64_t state = seed;
    do {
        make_reduced(&state, QS_ONE_HOT);
    } while (written.qubo.groups < 4 || written.qubo.couplings < 4 || !certify(make, 3));
    qs_certificate view;
    assert_int_equal(qs_certificate_open(c.file, c.size, &view, NULL), QS_OK);
    uint8_t *const parts[] = {c.file + (view.labelling - c.file),
                              c.file + (view.stage_bytes - c.file)};
    const uint64_t sizes[] = {view.sites * (uint64_t)view.label_bytes, view.stage_size};
    valid = refuted = malformed = 0;
    for (int i = 0; i < 2; i++) {
        for (uint64_t bit = 0; bit < 8 * sizes[i]; bit++) {
            parts[i][bit / 8] ^= (uint8_t)(1u << bit % 8);
            mend();
            note_what_is_true();
            parts[i][bit / 8] ^= (uint8_t)(1u << bit % 8);
        }
    }
    assert_true(refuted > 0 && malformed > 0);
}

static void no_bit_makes_a_lie(void **unused)
{
    (void)unused;
    made_by *const makers[] = {by_reduce, by_trws, by_trials, by_part, by_search};
    for (uint64_t i = 0; i < sizeof makers / sizeof makers[0]; i++) {
        stays_true_bit_by_bit(makers[i], 22 + i);
    }
}

/* Of problems that take trials, each in a stage of its own. */
static void no_certificate_of_trials_lies(void **unused)
{
    (void)unused;
    uint64_t state = 17;
    uint32_t stages = 0;
    valid = refuted = malformed = 0;
    for (int round = 0; round < ROUNDS / 8; round++) {
        make_frustrated(&state, 2);
        assert_true(certify(by_trials, 0));
        stages += qs_load_u32(c.file + COUNT_AT) > 2;
        stays_true(&state);
    }
    assert_true(stages > 10);
    assert_true(valid > 10 && refuted > 10 && malformed > 10);
}

/* Every truncation and every flipped bit of one file. */
static void is_noticed(made_by *make)
{
    uint64_t state = 8;
    do {
        make_reduced(&state, QS_ONE_HOT);
    } while (written.qubo.groups < 2 || !certify(make, 2));
    size_t size = c.size;
    qs_certificate view;
    for (size_t i = 0; i < size; i++) {
        uint8_t *part = malloc(i + !i);
        memcpy(part, c.file, i);
        assert_int_equal(qs_certificate_open(part, i, &view, NULL), QS_E_TRUNCATED);
        free(part);
    }
    for (size_t bit = 0; bit < 8 * size; bit++) {
        c.file[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_int_not_equal(qs_certificate_open(c.file, size, &view, NULL), QS_OK);
        c.file[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_int_equal(qs_certificate_open(c.file, size, &view, NULL), QS_OK);
}

static void stages_have_a_most(void)
{
    for (uint32_t over = 0; over < 2; over++) {
        qs_certificate view;
        qs_store_u32(c.file + COUNT_AT, QS_STAGES_MOST + over);
        mend();
        assert_int_equal(qs_certificate_open(c.file, c.size, &view, NULL),
                         over ? QS_E_CORRUPT : QS_OK);
    }
}

static void damage_is_noticed(void **unused)
{
    (void)unused;
    is_noticed(by_reduce);
    stages_have_a_most();
    is_noticed(by_cut);
    is_noticed(by_part);
    is_noticed(by_search);
}

/* The only stage of a certificate of a problem with three sites or more. */
static uint8_t *certified_stage(made_by *make, uint64_t seed)
{
    qs_certificate view;
    do {
        make_reduced(&seed, QS_ONE_HOT);
    } while (written.qubo.groups < 3 || written.qubo.couplings < 3 || !certify(make, 0));
    assert_int_equal(qs_certificate_open(c.file, c.size, &view, NULL), QS_OK);
    return c.file + (view.stage_bytes - c.file);
}

typedef struct field {
    size_t at; /* byte of a stage */
    uint32_t number;
} field;

/* Each one makes the stage malformed. */
static void are_refused(uint8_t *stage, const field *wrong, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t was = qs_load_u32(stage + wrong[i].at);
        qs_store_u32(stage + wrong[i].at, wrong[i].number);
        mend();
        assert_int_equal(check(), QS_E_CORRUPT);
        qs_store_u32(stage + wrong[i].at, was);
    }
}

/* A stage of one part, whose fields are changed. */
enum { COUNT = 16, VALUE = 20, SITES = 28 };

static void malformed_parts(void **unused)
{
    (void)unused;
    uint8_t *stage = certified_stage(by_part, 13);
    uint32_t count = qs_load_u32(stage + COUNT);
    assert_int_equal(count, written.qubo.groups);
    add_to((size_t)(stage + VALUE - c.file), 1);
    assert_false(c.verdict.valid);
    add_to((size_t)(stage + VALUE - c.file), -1);
    assert_true(c.verdict.valid);
    const field wrong[] = {
        {COUNT, 0},
        {COUNT, count - 1},
        {COUNT, count + 1},
        {COUNT, 1u << 31},
        {SITES, count},
        {SITES, qs_load_u32(stage + SITES + 4)},
        {0, 5},
        {0, 6},
        {4, 1},
    };
    are_refused(stage, wrong, sizeof wrong / sizeof wrong[0]);
}

/* A stage of one searched part. */
static void malformed_searches(void **unused)
{
    (void)unused;
    uint8_t *stage = certified_stage(by_search, 27);
    size_t sites = COUNT + 4, count = written.qubo.groups, bounds = sites + 4 * count;
    for (size_t i = 0; i < count; i++) { /* each is the least there is */
        add_to((size_t)(stage - c.file) + bounds + 8 * i, 1);
        assert_false(c.verdict.valid);
        add_to((size_t)(stage - c.file) + bounds + 8 * i, -1);
        assert_true(c.verdict.valid);
    }
    const field wrong[] = {
        {0, 9},
        {0, 12},
        {0, 16},
        {8, 1},
        {COUNT, 0},
        {COUNT, (uint32_t)count - 1},
        {COUNT, (uint32_t)count + 1},
        {sites, (uint32_t)count},
        {sites, qs_load_u32(stage + sites + 4)},
        {bounds + 4, 0x7fffffff},
        {bounds + 4, 0x80000000},
    };
    are_refused(stage, wrong, sizeof wrong / sizeof wrong[0]);
}

static void arguments(void **unused)
{
    (void)unused;
    uint64_t state = 9, memory[2];
    qs_certificate view;
    do {
        make_reduced(&state, QS_ONE_HOT);
    } while (written.qubo.groups < 2 || !certify(by_trws, 2));
    assert_int_equal(qs_certificate_open(c.file, c.size, NULL, NULL), QS_E_ARGUMENT);
    assert_int_equal(qs_certificate_open(written.file, written.size, &view, NULL), QS_E_FORMAT);
    assert_int_equal(qs_certificate_open(c.file, c.size, &view, NULL), QS_OK);
    assert_int_equal(
        qs_certificate_check(&written.index, &view, memory, sizeof memory, &c.verdict, NULL, NULL),
        QS_E_WORKSPACE);
    assert_int_equal(qs_certificate_check(&written.index, &view, NULL, 0, &c.verdict, NULL, NULL),
                     QS_E_ARGUMENT);
    qs_store_u32(c.file + 28, 4097);
    mend();
    assert_int_equal(check(), QS_E_CORRUPT); /* more stages than there may be */
    qs_store_u32(c.file + 28, view.stages);
    mend();
    written.file[written.size - 1] ^= 1; /* another problem */
    assert_int_equal(check(), QS_OK);
    assert_false(c.verdict.valid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(cuts_prove_the_optimum),
        cmocka_unit_test(descents_prove_the_optimum),
        cmocka_unit_test(a_large_descent_proves_the_optimum),
        cmocka_unit_test(cuts_of_tables_prove_the_optimum),
        cmocka_unit_test(reductions_hold),
        cmocka_unit_test(trials_hold),
        cmocka_unit_test(ends_when_nothing_is_gained),
        cmocka_unit_test(packed_ones_have_certificates),
        cmocka_unit_test(large_costs_have_certificates),
        cmocka_unit_test(parts_are_solved),
        cmocka_unit_test(parts_are_searched),
        cmocka_unit_test(reduced_problems_are_compared),
        cmocka_unit_test(too_much_is_refuted),
        cmocka_unit_test(no_certificate_lies),
        cmocka_unit_test(no_certificate_of_trials_lies),
        cmocka_unit_test(no_bit_makes_a_lie),
        cmocka_unit_test(damage_is_noticed),
        cmocka_unit_test(malformed_parts),
        cmocka_unit_test(malformed_searches),
        cmocka_unit_test(arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
