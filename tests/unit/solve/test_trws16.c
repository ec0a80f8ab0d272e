/* TRW-S in 16 bits beside a plain one in 64 bits with messages by definition, and beside every
 * labelling. */
#include "../tiny.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 4, HEIGHT = 3, SITES = WIDTH * HEIGHT, LABELS = 70, FEW = 21, ROUNDS = 300 };

static uint64_t memory[1 << 16];

typedef struct task {
    qs_problem problem;
    int32_t costs[SITES * LABELS], right[SITES], down[SITES];
} task;

static uint32_t below(uint64_t *state, uint32_t end)
{
    return tiny_random(state, end);
}

static void make_task(uint64_t *state, task *made)
{
    uint32_t width = 1 + below(state, WIDTH), height = 1 + below(state, HEIGHT);
    uint32_t labels = 1 + below(state, below(state, 8) == 0 ? LABELS : FEW);
    bool potts = below(state, 3) == 0, weighed = below(state, 2) == 0;
    memset(made, 0, sizeof *made);
    for (int i = 0; i < SITES * LABELS; i++) {
        made->costs[i] = (int32_t)below(state, 256) - 128;
    }
    for (int i = 0; i < SITES; i++) {
        made->right[i] = (int32_t)below(state, 40);
        made->down[i] = below(state, 4) == 0 ? 0 : (int32_t)below(state, 40);
    }
    made->problem = (qs_problem){.labels = labels,
                                 .scale = 1,
                                 .weight = (int32_t)below(state, 30),
                                 .grid = {.width = width, .height = height},
                                 .costs = made->costs};
    made->problem.pairwise.smoothness = potts ? QS_POTTS : QS_TRUNCATED_LINEAR;
    made->problem.pairwise.truncation = potts ? 0 : below(state, FEW + 2);
    if (weighed) {
        made->problem.grid.right = made->right;
        made->problem.grid.down = made->down;
    }
}

static qs_status solve(const task *given, uint64_t iterations, uint16_t *labelling,
                       qs_solution *found)
{
    qs_solve_options options = {.iterations = iterations};
    size_t size = qs_trws16_workspace(&given->problem, iterations);
    assert_true(size > 0 && size <= sizeof memory);
    memset(memory, 0xA5, size);
    return qs_trws16(&given->problem, &options, memory, size, labelling, found);
}

/* The plain one. Messages of the edge from each site to the right, and of that below. */
typedef struct plain {
    const qs_problem *problem;
    int64_t unit, messages[2][SITES][LABELS];
} plain;

static int64_t weight(const plain *of, int way, int x, int y)
{
    const qs_grid *grid = &of->problem->grid;
    bool is_edge =
        way == 0 ? x >= 0 && x + 1 < (int)grid->width : y >= 0 && y + 1 < (int)grid->height;
    const int32_t *weights = way == 0 ? grid->right : grid->down;
    int site = y * (int)grid->width + x;
    return !is_edge ? 0 : of->unit * (weights ? weights[site] : of->problem->weight);
}

static int64_t send(const plain *of, int64_t weight, const int64_t *costs, int64_t *message)
{
    uint32_t labels = of->problem->labels;
    int64_t least = INT64_MAX;
    for (uint32_t a = 0; a < labels; a++) {
        least = costs[a] < least ? costs[a] : least;
    }
    for (uint32_t b = 0; message && b < labels; b++) {
        message[b] = INT64_MAX;
        for (uint32_t a = 0; a < labels; a++) {
            int64_t cost = costs[a] - least + weight * qs_pairwise_cost(of->problem, a, b);
            message[b] = cost < message[b] ? cost : message[b];
        }
    }
    return least;
}

static int64_t visit(plain *of, int x, int y, bool forward, int64_t *least_sum)
{
    uint32_t labels = of->problem->labels;
    int width = (int)of->problem->grid.width, site = y * width + x;
    int64_t *near[4] = {x > 0 ? of->messages[0][site - 1] : NULL, of->messages[0][site],
                        y > 0 ? of->messages[1][site - width] : NULL, of->messages[1][site]};
    int64_t weights[4] = {weight(of, 0, x - 1, y), weight(of, 0, x, y), weight(of, 1, x, y - 1),
                          weight(of, 1, x, y)};
    int row = forward ? 1 : 0, column = forward ? 3 : 2;
    bool both = (weights[0] && weights[2]) || (weights[1] && weights[3]);
    int64_t costs[2][LABELS], least = INT64_MAX;
    for (uint32_t d = 0; d < labels; d++) {
        int64_t cost = of->problem->costs[(size_t)site * labels + d];
        least = cost < least ? cost : least;
    }
    for (uint32_t d = 0; d < labels; d++) {
        int64_t total = of->unit * (of->problem->costs[(size_t)site * labels + d] - least);
        for (int i = 0; i < 4; i++) {
            total += near[i] ? near[i][d] : 0;
        }
        int64_t part = both ? (total - (total % 2 != 0 && total < 0)) / 2
                       : weights[row] || !weights[column] ? total
                                                          : 0;
        costs[0][d] = part - (near[row] ? near[row][d] : 0);
        costs[1][d] = total - part - (near[column] ? near[column][d] : 0);
    }
    *least_sum += least;
    return send(of, weights[row], costs[0], near[row]) +
           send(of, weights[column], costs[1], near[column]);
}

static int64_t plain_bound(plain *of, int iterations)
{
    int width = (int)of->problem->grid.width, sites = width * (int)of->problem->grid.height;
    int64_t best = INT64_MIN;
    for (int pass = 0; pass < 2 * iterations; pass++) {
        int64_t bound = 0, least_sum = 0;
        for (int i = 0; i < sites; i++) {
            int site = pass % 2 == 0 ? i : sites - 1 - i;
            bound += visit(of, site % width, site / width, pass % 2 == 0, &least_sum);
        }
        int64_t whole = (bound + (bound > 0 ? of->unit - 1 : 0)) / of->unit + least_sum;
        best = whole > best ? whole : best;
        best = best < least_sum ? least_sum : best;
    }
    return best;
}

/* What a label costs beside the labels to the left and above, and beside those to the right and
 * below; those two count with their messages while they have no labels. */
static int64_t label_cost(const plain *of, int x, int y, uint32_t label, const uint16_t *labelling,
                          bool have_labels)
{
    const qs_problem *problem = of->problem;
    int width = (int)problem->grid.width, site = y * width + x;
    const int beside[4] = {site - 1, site + 1, site - width, site + width};
    const int64_t weights[4] = {weight(of, 0, x - 1, y), weight(of, 0, x, y),
                                weight(of, 1, x, y - 1), weight(of, 1, x, y)};
    int64_t cost = of->unit * problem->costs[(size_t)site * problem->labels + label];
    for (int i = 0; i < 4; i++) {
        if (i % 2 == 1 && !have_labels) {
            cost += of->messages[i / 2][site][label];
        } else if (weights[i] > 0) {
            cost += weights[i] * qs_pairwise_cost(problem, label, labelling[beside[i]]);
        }
    }
    return cost;
}

/* Each site takes its cheapest label in turn, and then that of a neighbour if it is cheaper. */
static void plain_labels(const plain *of, uint16_t *labelling)
{
    int width = (int)of->problem->grid.width, height = (int)of->problem->grid.height;
    for (int p = 0; p < width * height; p++) {
        int64_t least = INT64_MAX;
        for (uint32_t d = 0; d < of->problem->labels; d++) {
            int64_t cost = label_cost(of, p % width, p / width, d, labelling, false);
            labelling[p] = cost < least ? (uint16_t)d : labelling[p];
            least = cost < least ? cost : least;
        }
    }
    for (int p = 0; p < width * height; p++) {
        int x = p % width, y = p / width;
        const bool exists[4] = {x > 0, x + 1 < width, y > 0, y + 1 < height};
        const int beside[4] = {p - 1, p + 1, p - width, p + width};
        int64_t least = label_cost(of, x, y, labelling[p], labelling, true);
        for (int i = 0; i < 4; i++) {
            uint16_t label = exists[i] ? labelling[beside[i]] : labelling[p];
            int64_t cost = label_cost(of, x, y, label, labelling, true);
            labelling[p] = cost < least ? label : labelling[p];
            least = cost < least ? cost : least;
        }
    }
}

/* As the solver chooses it: the finest of 1/16 for which all sums fit. */
static int64_t unit_of(const task *given)
{
    plain of = {.problem = &given->problem, .unit = 1};
    int64_t most = 0, reach = 0;
    for (uint32_t d = 0; d < given->problem.labels; d++) {
        int64_t cost = qs_pairwise_cost(&given->problem, 0, d);
        reach = cost > reach ? cost : reach;
    }
    reach = reach > 0 ? reach : 1;
    for (int y = 0; y < (int)given->problem.grid.height; y++) {
        for (int x = 0; x < (int)given->problem.grid.width; x++) {
            int64_t right = weight(&of, 0, x, y), down = weight(&of, 1, x, y);
            most = right > most ? right : most;
            most = down > most ? down : most;
        }
    }
    int64_t unit = 1;
    while (unit < 16 && (255 + 4 * most * reach) * 2 * unit < 16384) {
        unit *= 2;
    }
    return unit;
}

static void it_computes_as_a_plain_one(void **unused)
{
    (void)unused;
    uint64_t state = 11;
    task given;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[SITES], expected[SITES];
        qs_solution found;
        int64_t energy;
        int iterations = 1 + round % 3;
        make_task(&state, &given);
        assert_int_equal(solve(&given, (uint64_t)iterations, labelling, &found), QS_OK);
        plain of = {.problem = &given.problem, .unit = unit_of(&given)};
        assert_int_equal(found.lower_bound, plain_bound(&of, iterations));
        plain_labels(&of, expected);
        assert_memory_equal(labelling, expected,
                            sizeof *labelling * (size_t)qs_problem_sites(&given.problem));
        assert_int_equal(found.iterations, iterations);
        size_t size = qs_problem_workspace(&given.problem);
        assert_true(size <= sizeof memory);
        assert_int_equal(
            qs_problem_energy(&given.problem, labelling, memory, sizeof memory, &energy), QS_OK);
        assert_int_equal(energy, found.energy);
        assert_true(found.lower_bound <= found.energy);
        assert_true(found.converged == (found.energy == found.lower_bound));
    }
}

/* A single row is a chain: TRW-S proves its optimum. */
static void a_chain_is_solved(void **unused)
{
    (void)unused;
    uint64_t state = 5;
    task given;
    for (int round = 0; round < ROUNDS; round++) {
        uint16_t labelling[SITES];
        qs_solution found;
        make_task(&state, &given);
        given.problem.grid.height = 1;
        assert_int_equal(solve(&given, 1, labelling, &found), QS_OK);
        assert_int_equal(found.energy, found.lower_bound);
    }
}

typedef struct seen {
    int calls;
    int64_t energy; /* at the first call */
} seen;

static bool stop_at_once(void *context, const qs_progress *progress)
{
    seen *so_far = context;
    assert_true(progress->lower_bound <= progress->energy);
    so_far->energy = so_far->calls == 0 ? progress->energy : so_far->energy;
    so_far->calls++;
    return false;
}

static void a_watch_sees_the_end(void **unused)
{
    (void)unused;
    uint64_t state = 3;
    int64_t energy;
    seen saw = {0, 0};
    uint16_t labelling[SITES], zeros[SITES] = {0};
    qs_solution found;
    task given;
    make_task(&state, &given);
    qs_solve_options options = {.iterations = 9, .watch = stop_at_once, .context = &saw};
    assert_int_equal(qs_trws16(&given.problem, &options, memory, sizeof memory, labelling, &found),
                     QS_OK);
    assert_true(saw.calls > 0 && found.iterations <= 1);
    assert_int_equal(qs_problem_energy(&given.problem, zeros, memory, sizeof memory, &energy),
                     QS_OK);
    assert_int_equal(saw.energy, energy); /* until there are labels they are all 0 */
}

static void it_refuses_what_does_not_fit(void **unused)
{
    (void)unused;
    uint64_t state = 7;
    uint16_t labelling[SITES];
    qs_solution found;
    task given;
    do {
        make_task(&state, &given);
    } while (given.problem.grid.right || given.problem.grid.width < 2 || given.problem.labels < 3 ||
             given.problem.pairwise.smoothness == QS_POTTS);
    size_t size = qs_trws16_workspace(&given.problem, 0);
    assert_int_equal(qs_trws16(&given.problem, NULL, memory, size - 1, labelling, &found),
                     QS_E_WORKSPACE);
    given.costs[1] = given.costs[0] + 256;
    given.costs[2] = given.costs[0];
    assert_int_equal(solve(&given, 1, labelling, &found), QS_E_OVERFLOW);
    given.costs[1] = given.costs[0];
    assert_int_equal(solve(&given, 1, labelling, &found), QS_OK);
    given.problem.pairwise.truncation = 1;
    given.problem.weight = (16383 - 255) / 4;
    assert_int_equal(solve(&given, 1, labelling, &found), QS_OK);
    given.problem.weight++;
    assert_int_equal(solve(&given, 1, labelling, &found), QS_E_OVERFLOW);
    given.problem.weight = 1;
    given.problem.pairwise.smoothness = QS_TRUNCATED_QUADRATIC;
    assert_int_equal(qs_trws16_workspace(&given.problem, 0), 0);
    assert_int_equal(qs_trws16(&given.problem, NULL, memory, size, labelling, &found),
                     QS_E_ENCODING);
    assert_int_equal(qs_trws16(NULL, NULL, memory, size, labelling, &found), QS_E_ARGUMENT);
}

/* ---- A larger problem, whose costs are made. */

enum { ACROSS = 150, DOWN = 90, MANY = 64 };

static void make_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    uint8_t *out = costs;
    uint32_t labels = *(const uint32_t *)context;
    for (uint32_t x = 0; x < ACROSS; x++, out += labels) {
        for (uint32_t d = 0; d < labels; d++) {
            out[d] = (uint8_t)((x * 7919u + row * 104729u + d * 31u) * 2654435761u >> 26);
        }
        out[(x / 20 + row / 20) % labels] = 0;
        least[x] = (int32_t)(x % 3) - 1;
    }
}

static qs_problem large_problem(const uint32_t *labels, uint8_t copies)
{
    return (qs_problem){
        .labels = *labels,
        .scale = 1,
        .weight = 20,
        .grid = {.width = ACROSS, .height = DOWN},
        .pairwise = {.smoothness = QS_TRUNCATED_LINEAR, .truncation = 3},
        .source = {
            .row = make_row, .context = (void *)(uintptr_t)labels, .bytes = 1, .copies = copies}};
}

/* fill  what the workspace holds before: it must not matter */
static void solve_large(const qs_problem *problem, const qs_solve_options *options, int fill,
                        uint16_t *labelling, qs_solution *found)
{
    size_t size = qs_trws16_workspace(problem, options->iterations);
    void *workspace = malloc(size);
    int64_t energy;
    assert_non_null(workspace);
    memset(workspace, fill, size);
    assert_int_equal(qs_trws16(problem, options, workspace, size, labelling, found), QS_OK);
    assert_int_equal(qs_problem_energy(problem, labelling, workspace, size, &energy), QS_OK);
    assert_int_equal(energy, found->energy);
    assert_true(found->lower_bound <= energy);
    free(workspace);
}

/* Does the parts from the last one to the first. */
static void backwards(void *helpers, qs_part *part, void *work, uint32_t parts)
{
    uint32_t *most = helpers;
    *most = parts > *most ? parts : *most;
    while (parts-- > 0) {
        part(work, parts);
    }
}

static void parts_in_any_order_give_the_same(void **unused)
{
    (void)unused;
    static uint16_t alone[ACROSS * DOWN], labelling[ACROSS * DOWN];
    static const uint32_t sizes[] = {MANY, 21};
    for (uint32_t round = 0; round < 12; round++) {
        uint32_t most = 0, workers = 1 + 3 * (round / 4);
        qs_problem problem = large_problem(&sizes[round % 2], 3);
        qs_solve_options options = {.iterations = 1 + round / 2 % 2};
        qs_solution expected, found;
        solve_large(&problem, &options, 0x5A, alone, &expected);
        options.together = backwards;
        options.helpers = &most;
        options.workers = workers;
        solve_large(&problem, &options, 0x5A, labelling, &found);
        assert_true(most >= workers && most >= problem.source.copies);
        assert_memory_equal(labelling, alone, sizeof alone);
        assert_int_equal(found.lower_bound, expected.lower_bound);
        assert_int_equal(found.iterations, expected.iterations);
    }
}

static bool stop_later(void *context, const qs_progress *progress)
{
    (void)progress;
    int *left = context;
    return (*left)-- > 0;
}

/* Wherever the watch stops it, there is a labelling, and its energy. */
static void it_stops_within_a_pass(void **unused)
{
    (void)unused;
    static uint16_t labelling[2][ACROSS * DOWN];
    static const uint32_t labels = MANY;
    uint32_t most = 0;
    qs_problem problem = large_problem(&labels, 0);
    for (int calls = 0; calls < 12; calls++) {
        for (int again = 0; again < 2; again++) {
            int left = calls / 2;
            qs_solution found;
            qs_solve_options options = {.iterations = 1 + (uint64_t)calls % 2,
                                        .watch = stop_later,
                                        .context = &left,
                                        .together = calls % 4 < 2 ? backwards : NULL,
                                        .helpers = &most,
                                        .workers = 3};
            solve_large(&problem, &options, again ? 0x11 : 0x5A, labelling[again], &found);
        }
        assert_memory_equal(labelling[0], labelling[1], sizeof labelling[0]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_computes_as_a_plain_one),
        cmocka_unit_test(a_chain_is_solved),
        cmocka_unit_test(a_watch_sees_the_end),
        cmocka_unit_test(it_refuses_what_does_not_fit),
        cmocka_unit_test(parts_in_any_order_give_the_same),
        cmocka_unit_test(it_stops_within_a_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
