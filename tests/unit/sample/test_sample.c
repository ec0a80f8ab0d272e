/* Samples of every encoding, over the labels that are left: what they mean, and their repair
 * (docs/FORMAT.md, labl; docs/MATHS.md). */
#include "slow.h"

#include <string.h>

#include "qubo/blocks.h"
#include "base/bytes.h"

enum { ROUNDS = 500, BITS = 16, FEW = 11, DRAWN = 150, BYTES = SLOW_VARIABLES / 8 };

static tiny t;
static slow_qubo q;
static slow_request request;

static const qs_encoding encodings[] = {QS_ONE_HOT,      QS_ONE_HOT_SPARSE, QS_DOMAIN_WALL,
                                        QS_MULTIWAY_CUT, QS_ST_CUT,         QS_ST_CUT_ARCS};

/* A random problem that the encoding fits, some labels of it left. */
static void make(uint64_t *state, qs_encoding encoding)
{
    do {
        tiny_make(&t, state, BITS, false);
    } while (!slow_fits(&t.problem, encoding));
    request = (slow_request){.problem = &t.problem,
                             .encoding = encoding,
                             .gap = 1 + tiny_random(state, 3),
                             .truncate = tiny_random(state, 3) == 0};
    request.penalty = tiny_random(state, 2) == 0 ? QS_PENALTY_LOCAL : QS_PENALTY_MINIMAL;
    slow_choose_labels(&request, state);
    slow_encode(&request, &q);
}

static bool bit(const uint8_t *bits, uint32_t i)
{
    return bits[i / 8] >> i % 8 & 1;
}

static uint32_t size_of(uint32_t site)
{
    uint32_t size = 0;
    for (uint32_t d = 0; d < t.problem.labels; d++) {
        size += request.kept[site][d];
    }
    return size;
}

/* The table of docs/FORMAT.md: variable i of a site that has its label j. */
static bool expected(uint32_t i, uint32_t j)
{
    switch (request.encoding) {
    case QS_DOMAIN_WALL: return i < j;
    case QS_ST_CUT:
    case QS_ST_CUT_ARCS: return i <= j;
    default: return i == j;
    }
}

static uint32_t variables_of(uint32_t size)
{
    return request.encoding == QS_DOMAIN_WALL ? size - 1
           : request.encoding >= QS_ST_CUT    ? size + 1
                                              : size;
}

/* By that table: how much is not a labelling; the labels of what is. */
static uint32_t count_infeasible(const uint8_t *bits, uint16_t *labelling)
{
    uint32_t at = 0, wrong = 0, open = 0, labels = t.problem.labels;
    for (uint32_t p = 0; p < qs_problem_sites(&t.problem); p++) {
        uint32_t size = size_of(p), variables = size > 1 ? variables_of(size) : 0, found = 0,
                 rank = 0;
        open += size > 1;
        for (uint32_t d = 0; d < labels; d++) {
            bool same = request.kept[p][d];
            for (uint32_t i = 0; i < variables; i++) {
                same = same && bit(bits, at + i) == expected(i, rank);
            }
            rank += request.kept[p][d];
            found += same;
            labelling[p] = same ? (uint16_t)d : labelling[p];
        }
        wrong += found != 1;
        at += variables;
    }
    for (uint32_t g = 0; open > 0 && request.encoding == QS_MULTIWAY_CUT && g < labels; g++) {
        bool same = true;
        for (uint32_t d = 0; d < labels; d++) {
            same = same && bit(bits, at + g * labels + d) == (d == g);
        }
        wrong += !same;
    }
    return wrong + (open > 0 && request.encoding >= QS_ST_CUT
                        ? !bit(bits, at) + (uint32_t)bit(bits, at + 1)
                        : 0);
}

/* State `number`: all of them where there are few variables, else drawn. False when there are
 * enough. */
static bool make_state(uint64_t *state, uint32_t number, uint8_t *bits)
{
    uint32_t n = q.qubo.variables;
    memset(bits, 0, BYTES);
    if (n <= FEW) {
        tiny_bits(number, bits);
        return number < 1u << n;
    }
    uint16_t labelling[TINY_SITES];
    slow_first(&request, labelling);
    uint32_t kind = tiny_random(state, 4);
    if (kind == 0) { /* a few flips away from a labelling */
        for (uint32_t steps = tiny_random(state, 20); steps > 0 && slow_next(&request, labelling);
             steps--) {
        }
        assert_int_equal(qs_sample_encode(&q.index, labelling, bits), QS_OK);
        for (uint32_t flips = tiny_random(state, 4); flips > 0; flips--) {
            uint32_t i = tiny_random(state, n);
            bits[i / 8] ^= (uint8_t)(1u << i % 8);
        }
    }
    for (uint32_t i = 0; kind > 0 && i < n; i++) {
        bits[i / 8] |= (uint8_t)((tiny_random(state, 4) < kind) << i % 8);
    }
    return number < DRAWN;
}

/* H + what truncation took = F; a label that is not left is refused. */
static void labellings_come_and_go(void **unused)
{
    (void)unused;
    uint64_t state = 31;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state, encodings[round % 6]);
        uint16_t labelling[TINY_SITES], again[TINY_SITES], by_table[TINY_SITES];
        uint32_t sites = qs_problem_sites(&t.problem);
        assert_int_equal(q.qubo.labels.sites, sites);
        slow_first(&request, labelling);
        int left = 200;
        do {
            uint8_t bits[BYTES];
            assert_int_equal(qs_sample_encode(&q.index, labelling, bits), QS_OK);
            assert_int_equal(qs_sample_infeasible(&q.index, bits), 0);
            assert_int_equal(count_infeasible(bits, by_table), 0);
            assert_memory_equal(by_table, labelling, sites * sizeof *labelling);
            assert_int_equal(qs_sample_decode(&q.index, bits, again), QS_OK);
            assert_memory_equal(again, labelling, sites * sizeof *labelling);
            assert_int_equal(qs_qubo_energy(&q.index, bits) + qs_sample_trimmed(&q.qubo, labelling),
                             slow_energy(&t.problem, labelling));
            assert_true(request.truncate || qs_sample_trimmed(&q.qubo, labelling) == 0);
        } while (--left > 0 && slow_next(&request, labelling));
        for (uint32_t p = 0; p < sites; p++) {
            for (uint16_t d = 0; d <= t.problem.labels; d++) {
                uint8_t bits[BYTES];
                slow_first(&request, labelling);
                labelling[p] = d;
                bool fine = d < t.problem.labels && request.kept[p][d];
                assert_int_equal(qs_sample_encode(&q.index, labelling, bits),
                                 fine ? QS_OK : QS_E_ARGUMENT);
            }
        }
    }
}

static void states_are_told_from_labellings(void **unused)
{
    (void)unused;
    uint64_t state = 32;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t bits[BYTES];
        uint16_t labelling[TINY_SITES], decoded[TINY_SITES];
        make(&state, encodings[round % 6]);
        for (uint32_t i = 0; make_state(&state, i, bits); i++) {
            uint32_t wrong = count_infeasible(bits, labelling);
            assert_int_equal(qs_sample_infeasible(&q.index, bits), wrong);
            assert_int_equal(qs_sample_decode(&q.index, bits, decoded),
                             wrong > 0 ? QS_E_INFEASIBLE : QS_OK);
            if (wrong == 0) {
                assert_memory_equal(decoded, labelling,
                                    qs_problem_sites(&t.problem) * sizeof *labelling);
            }
        }
    }
}

/* H never rises, and falls by the gap where there was something to repair; what was a labelling
 * stays one. */
static void repair_never_raises(void **unused)
{
    (void)unused;
    static uint64_t memory[4096];
    uint64_t state = 33;
    uint32_t repairs[QS_ST_CUT_ARCS + 1] = {0};
    for (int round = 0; round < 2 * ROUNDS; round++) {
        uint8_t bits[BYTES];
        uint16_t before[TINY_SITES], after[TINY_SITES];
        qs_encoding encoding = encodings[round % 6];
        make(&state, encoding);
        size_t size = qs_repair_workspace(&q.index);
        assert_true(size <= sizeof memory);
        for (uint32_t i = 0; make_state(&state, i, bits); i++) {
            uint32_t repaired, wrong = count_infeasible(bits, before);
            int64_t energy = qs_qubo_energy(&q.index, bits);
            memset(memory, 0x5a, sizeof memory);
            assert_int_equal(qs_sample_repair(&q.index, bits, memory, size, &repaired), QS_OK);
            assert_int_equal(repaired, wrong);
            assert_int_equal(qs_sample_infeasible(&q.index, bits), 0);
            assert_int_equal(count_infeasible(bits, after), 0);
            assert_true(qs_qubo_energy(&q.index, bits) <= energy - (wrong > 0 ? request.gap : 0));
            if (wrong == 0) {
                assert_memory_equal(before, after, qs_problem_sites(&t.problem) * sizeof *after);
            }
            repairs[encoding] += wrong > 0;
        }
        if (size > 0) {
            assert_int_equal(qs_sample_repair(&q.index, bits, memory, size - 1, NULL),
                             QS_E_WORKSPACE);
            assert_int_equal(qs_sample_repair(&q.index, bits, NULL, size, NULL), QS_E_ARGUMENT);
        }
    }
    for (int i = 0; i < 6; i++) {
        assert_true(repairs[encodings[i]] > 10000);
    }
}

/* Small costs, six labels and edges of very different weights: which way steps are moved decides.
 */
static void steps_go_the_cheaper_way(void **unused)
{
    (void)unused;
    static uint64_t memory[4096];
    static const qs_encoding linear[] = {QS_DOMAIN_WALL, QS_ST_CUT, QS_ST_CUT_ARCS};
    uint64_t state = 38;
    for (int round = 0; round < ROUNDS; round++) {
        memset(&t, 0, sizeof t);
        uint32_t sites = 2 + tiny_random(&state, 3), edges = 0;
        for (uint32_t a = 0; a < sites; a++) {
            for (uint32_t b = a + 1; b < sites; b++) {
                t.edges[edges++] = (qs_edge){
                    a, b, tiny_random(&state, 3) == 0 ? 40 : (int32_t)tiny_random(&state, 3)};
            }
        }
        for (uint32_t i = 0; i < 6 * sites; i++) {
            t.costs[i] = (int32_t)tiny_random(&state, 2);
        }
        t.problem = (qs_problem){.sites = sites,
                                 .labels = 6,
                                 .scale = 1,
                                 .pairwise = {QS_TRUNCATED_LINEAR, 0, NULL},
                                 .edges = t.edges,
                                 .edge_count = edges,
                                 .costs = t.costs};
        request = (slow_request){.problem = &t.problem, .encoding = linear[round % 3], .gap = 1};
        slow_choose_labels(&request, &state);
        slow_encode(&request, &q);
        for (int i = 0; i < 30; i++) {
            uint8_t bits[BYTES] = {0};
            uint16_t labelling[TINY_SITES];
            for (uint32_t v = 0; v < q.qubo.variables; v++) {
                bits[v / 8] |= (uint8_t)(tiny_random(&state, 2) << v % 8);
            }
            /* Source and sink right, and arcs too: what is left are the steps. */
            if (request.encoding >= QS_ST_CUT && q.qubo.variables > 0) {
                uint32_t at = 0;
                for (uint32_t p = 0; p < sites; p++) {
                    at += size_of(p) > 1 ? size_of(p) + 1 : 0;
                }
                bits[at / 8] |= (uint8_t)(1u << at % 8);
                bits[(at + 1) / 8] &= (uint8_t)~(1u << (at + 1) % 8);
                int64_t least = qs_qubo_energy(&q.index, bits);
                for (uint32_t z = at + 2; z < q.qubo.variables; z++) {
                    bits[z / 8] ^= (uint8_t)(1u << z % 8);
                    int64_t energy = qs_qubo_energy(&q.index, bits);
                    if (energy < least) {
                        least = energy;
                    } else {
                        bits[z / 8] ^= (uint8_t)(1u << z % 8);
                    }
                }
            }
            int64_t energy = qs_qubo_energy(&q.index, bits),
                    wrong = count_infeasible(bits, labelling);
            assert_int_equal(qs_sample_repair(&q.index, bits, memory, sizeof memory, NULL), QS_OK);
            assert_int_equal(count_infeasible(bits, labelling), 0);
            assert_true(qs_qubo_energy(&q.index, bits) <= energy - (wrong > 0));
        }
    }
}

/* The labels d of a site with x_pd = 1, where a wall's x is u_i - u_i+1; `at` is its first
 * variable. */
static uint32_t candidates(const uint8_t *bits, uint32_t site, uint32_t at, uint16_t *labels)
{
    uint32_t rank = 0, count = 0, size = size_of(site);
    for (uint16_t d = 0; d < t.problem.labels; d++) {
        bool wall = request.encoding == QS_DOMAIN_WALL,
             u = wall && (rank == 0 || bit(bits, at + rank - 1)),
             next = wall && rank + 1 < size && bit(bits, at + rank);
        if (request.kept[site][d] && (size == 1 || (wall ? u && !next : bit(bits, at + rank)))) {
            labels[count++] = d;
        }
        rank += request.kept[site][d];
    }
    return count;
}

static int64_t labelling_energy(const uint16_t *labelling)
{
    uint8_t bits[BYTES];
    assert_int_equal(qs_sample_encode(&q.index, labelling, bits), QS_OK);
    return qs_qubo_energy(&q.index, bits);
}

/* The sum of H over all choices of a candidate for each site by itself, and their number. */
static int64_t sum_of_choices(uint16_t choices[][TINY_LABELS], const uint32_t *counts,
                              uint32_t sites, int64_t *number)
{
    uint32_t at[TINY_SITES] = {0};
    int64_t sum = 0;
    *number = 0;
    for (bool more = true; more;) {
        uint16_t labelling[TINY_SITES];
        for (uint32_t p = 0; p < sites; p++) {
            labelling[p] = choices[p][at[p]];
        }
        sum += labelling_energy(labelling);
        ++*number;
        more = false;
        for (uint32_t p = 0; p < sites && !more; p++) {
            more = ++at[p] < counts[p];
            at[p] = more ? at[p] : 0;
        }
    }
    return sum;
}

/* The same over all orders of the labels, each site taking the first of its candidates in it. */
static int64_t sum_of_orders(uint16_t choices[][TINY_LABELS], const uint32_t *counts,
                             uint32_t sites, int64_t *number)
{
    uint32_t labels = t.problem.labels, swaps[TINY_LABELS] = {0};
    uint16_t place[TINY_LABELS] = {0, 1, 2, 3, 4, 5}; /* of each label in the order */
    int64_t sum = 0;
    *number = 0;
    for (uint32_t i = 0; i < labels;) { /* Heap's permutations */
        bool fresh = i == 0;
        if (fresh) {
            uint16_t labelling[TINY_SITES];
            for (uint32_t p = 0; p < sites; p++) {
                labelling[p] = choices[p][0];
                for (uint32_t c = 1; c < counts[p]; c++) {
                    labelling[p] =
                        place[choices[p][c]] < place[labelling[p]] ? choices[p][c] : labelling[p];
                }
            }
            sum += labelling_energy(labelling);
            ++*number;
        }
        for (i = 0; i < labels && swaps[i] >= i; i++) {
            swaps[i] = 0;
        }
        if (i < labels) {
            uint32_t with = i % 2 == 0 ? 0 : swaps[i];
            uint16_t kept = place[with];
            place[with] = place[i];
            place[i] = kept;
            swaps[i]++;
            i = 0;
        }
    }
    return sum;
}

/* What is made certain step by step ends no higher than chance is expected to. */
static void repair_is_no_worse_than_chance(void **unused)
{
    (void)unused;
    static uint64_t memory[4096];
    uint64_t state = 37;
    uint32_t better[2] = {0};
    for (int round = 0; round < 2 * ROUNDS; round++) {
        make(&state, round % 2 == 0 ? QS_ONE_HOT_SPARSE : QS_DOMAIN_WALL);
        uint32_t labels = t.problem.labels, tau = t.problem.pairwise.truncation;
        bool potts = t.problem.pairwise.smoothness == QS_POTTS,
             wall = request.encoding == QS_DOMAIN_WALL;
        if (wall ? !potts && (tau == 0 || tau >= labels - 1)
                 : request.penalty != QS_PENALTY_MINIMAL) {
            continue; /* repaired in another way */
        }
        for (int i = 0; i < 20; i++) {
            uint8_t bits[BYTES] = {0};
            uint16_t choices[TINY_SITES][TINY_LABELS];
            uint32_t counts[TINY_SITES], at = 0, sites = qs_problem_sites(&t.problem);
            for (uint32_t v = 0; v < q.qubo.variables; v++) {
                bits[v / 8] |= (uint8_t)(tiny_random(&state, 2) << v % 8);
            }
            bool full = true;
            for (uint32_t p = 0; p < sites; p++) {
                counts[p] = candidates(bits, p, at, choices[p]);
                full = full && counts[p] > 0;
                at += size_of(p) > 1 ? variables_of(size_of(p)) : 0;
            }
            if (!full) {
                continue;
            }
            int64_t number, sum = potts ? sum_of_orders(choices, counts, sites, &number)
                                        : sum_of_choices(choices, counts, sites, &number);
            assert_int_equal(qs_sample_repair(&q.index, bits, memory, sizeof memory, NULL), QS_OK);
            int64_t energy = qs_qubo_energy(&q.index, bits);
            assert_true(energy * number <= sum);
            better[potts] += energy * number < sum;
        }
    }
    assert_true(better[0] > 1000 && better[1] > 1000);
}

/* The least H of all states is the least F of the labels left, and every infeasible state lies the
 * gap above it: the second opinion on the penalties. */
static void minima_agree(void **unused)
{
    (void)unused;
    uint64_t state = 34;
    for (int round = 0; round < ROUNDS; round++) {
        uint8_t bits[BYTES];
        uint16_t labelling[TINY_SITES];
        make(&state, encodings[round % 5]);
        if (q.qubo.variables > FEW) {
            continue;
        }
        int64_t least = INT64_MAX, feasible = INT64_MAX, infeasible = INT64_MAX;
        slow_first(&request, labelling);
        do {
            int64_t energy = slow_energy(&t.problem, labelling);
            least = energy < least ? energy : least;
        } while (slow_next(&request, labelling));
        for (uint32_t i = 0; make_state(&state, i, bits); i++) {
            int64_t energy = qs_qubo_energy(&q.index, bits),
                    *of = count_infeasible(bits, labelling) > 0 ? &infeasible : &feasible;
            *of = energy < *of ? energy : *of;
        }
        assert_int_equal(feasible, least);
        assert_true(infeasible >= least + request.gap || infeasible == INT64_MAX);
    }
}

static int64_t energy_of(uint32_t i, uint32_t j)
{
    uint8_t bits[BYTES] = {0};
    bits[i / 8] |= (uint8_t)(1u << i % 8);
    bits[j / 8] |= (uint8_t)(1u << j % 8);
    return qs_qubo_energy(&q.index, bits);
}

/* From energies of no, one and two variables at 1. */
static void ising_beside(const char *what)
{
    static uint64_t memory[4096];
    qs_ising expected_range = {0}, got;
    uint8_t none[BYTES] = {0};
    uint32_t n = q.qubo.variables, pairs = 0;
    int64_t offset = qs_qubo_energy(&q.index, none);
    for (uint32_t i = 0; i < n; i++) {
        int64_t own = energy_of(i, i) - offset, field = 2 * own;
        for (uint32_t j = 0; j < n; j++) {
            int64_t pair =
                i == j ? 0 : energy_of(i, j) - energy_of(i, i) - energy_of(j, j) + offset;
            field += pair;
            if (pair != 0) {
                bool first = pairs++ == 0;
                expected_range.coupling_min = first || pair < expected_range.coupling_min
                                                  ? pair
                                                  : expected_range.coupling_min;
                expected_range.coupling_max = first || pair > expected_range.coupling_max
                                                  ? pair
                                                  : expected_range.coupling_max;
            }
        }
        expected_range.field_min =
            i == 0 || field < expected_range.field_min ? field : expected_range.field_min;
        expected_range.field_max =
            i == 0 || field > expected_range.field_max ? field : expected_range.field_max;
    }
    size_t size = qs_ising_workspace(&q.qubo);
    assert_true(size <= sizeof memory);
    assert_int_equal(qs_qubo_ising(&q.index, memory, size, &got), QS_OK);
    if (memcmp(&got, &expected_range, sizeof got) != 0) {
        fail_msg("%s, encoding %d: ranges differ", what, request.encoding);
    }
    if (size > 0) {
        assert_int_equal(qs_qubo_ising(&q.index, memory, size - 1, &got), QS_E_WORKSPACE);
    }
}

static void ising_ranges(void **unused)
{
    (void)unused;
    uint64_t state = 35;
    for (int round = 0; round < ROUNDS; round++) {
        make(&state, encodings[round % 6]);
        ising_beside("tables");
        tiny_qubo streamed; /* Toeplitz blocks */
        tiny_encode(&t.problem, (qs_encode_options){.encoding = QS_ONE_HOT}, &streamed);
        memcpy(q.file, streamed.file, streamed.size);
        q.size = streamed.size;
        slow_open(&q);
        ising_beside("diagonals");
    }
}

/* Toeplitz blocks of every shape beside the definition. */
static void block_sums(void **unused)
{
    (void)unused;
    uint64_t state = 36;
    for (int round = 0; round < ROUNDS; round++) {
        uint32_t rows = 1 + tiny_random(&state, 6), columns = 1 + tiny_random(&state, 6),
                 count = tiny_random(&state, rows + columns);
        uint32_t first = count > 0 ? 1 - rows + tiny_random(&state, rows + columns - count) : 0;
        uint8_t block[24 + 4 * 12];
        const uint32_t head[6] = {rows, columns, 1, tiny_random(&state, 9) - 4, first, count};
        for (uint32_t i = 0; i < 6 + count; i++) {
            qs_store_u32(block + 4 * i, i < 6 ? head[i] : tiny_random(&state, 100) - 50);
        }
        assert_int_equal(qs_block_size(block, sizeof block), 24 + 4 * count);
        int64_t row[6], column[6], own[6], row_sum[6] = {0}, column_sum[6] = {0}, own_sum[6] = {0};
        for (uint32_t i = 0; i < rows; i++) {
            for (uint32_t j = 0; j < columns; j++) {
                int64_t entry = qs_block_entry(block, i, j);
                row_sum[i] += entry;
                column_sum[j] += entry;
                own_sum[i] += j > i ? entry : 0;
                own_sum[j] += j > i ? entry : 0;
            }
        }
        qs_block_sums(block, row, column);
        assert_memory_equal(row, row_sum, rows * sizeof *row);
        assert_memory_equal(column, column_sum, columns * sizeof *column);
        if (rows == columns) {
            qs_block_own_sums(block, own);
            assert_memory_equal(own, own_sum, rows * sizeof *own);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(labellings_come_and_go),
        cmocka_unit_test(states_are_told_from_labellings),
        cmocka_unit_test(repair_never_raises),
        cmocka_unit_test(repair_is_no_worse_than_chance),
        cmocka_unit_test(steps_go_the_cheaper_way),
        cmocka_unit_test(minima_agree),
        cmocka_unit_test(ising_ranges),
        cmocka_unit_test(block_sums),
    };
    return cmocka_run_group_tests_name("sample", tests, NULL, NULL);
}
