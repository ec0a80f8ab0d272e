/* Labels near those of a labelling, beside every labelling of such labels. */
#include "../tiny.h"

#include <string.h>

enum { WIDTH = 5, HEIGHT = 4, SITES = WIDTH * HEIGHT, LABELS = 9, ROUNDS = 300 };

static uint64_t memory[1 << 12];

typedef struct task {
    qs_problem problem;
    int32_t costs[SITES * LABELS], right[SITES], down[SITES];
} task;

static void no_row(void *context, uint32_t row, void *costs, int32_t *least)
{
    (void)context, (void)row, (void)costs, (void)least;
    fail_msg("the costs of all labels are not needed");
}

static void pick(void *context, uint32_t row, const uint16_t *labels, int32_t *costs)
{
    const task *of = context;
    uint32_t width = of->problem.grid.width;
    for (uint32_t x = 0; x < width; x++) {
        assert_true(labels[x] < of->problem.labels);
        costs[x] = of->costs[((size_t)row * width + x) * of->problem.labels + labels[x]];
    }
}

static void make_task(uint64_t *state, task *made)
{
    bool potts = tiny_random(state, 3) == 0, weighed = tiny_random(state, 2) == 0;
    memset(made, 0, sizeof *made);
    for (int i = 0; i < SITES * LABELS; i++) {
        made->costs[i] = (int32_t)tiny_random(state, 60) - 30;
    }
    for (int i = 0; i < SITES; i++) {
        made->right[i] = (int32_t)tiny_random(state, 20);
        made->down[i] = (int32_t)tiny_random(state, 20);
    }
    made->problem = (qs_problem){
        .labels = 1 + tiny_random(state, LABELS),
        .scale = 1,
        .weight = (int32_t)tiny_random(state, 15),
        .grid = {.width = 1 + tiny_random(state, WIDTH), .height = 1 + tiny_random(state, HEIGHT)},
        .source = {.row = no_row, .context = made, .bytes = 4, .pick = pick}};
    made->problem.pairwise.smoothness = potts ? QS_POTTS : QS_TRUNCATED_LINEAR;
    made->problem.pairwise.truncation = potts ? 0 : tiny_random(state, LABELS + 1);
    if (weighed) {
        made->problem.grid.right = made->right;
        made->problem.grid.down = made->down;
    }
}

static int64_t energy_of(const qs_problem *problem, const uint16_t *labelling)
{
    int64_t energy = 0;
    assert_int_equal(qs_problem_energy(problem, labelling, memory, sizeof memory, &energy), QS_OK);
    return energy;
}

static int64_t improve(const task *given, uint64_t iterations, uint16_t *labelling)
{
    qs_solve_options options = {.iterations = iterations};
    qs_solution found;
    size_t size = qs_near_workspace(&given->problem);
    assert_true(size > 0 && size <= sizeof memory);
    memset(memory, 0xA5, size);
    assert_int_equal(qs_near(&given->problem, &options, memory, size, labelling, &found), QS_OK);
    assert_int_equal(found.energy, energy_of(&given->problem, labelling));
    assert_int_equal(found.lower_bound, QS_NO_BOUND);
    return found.energy;
}

static void random_labels(uint64_t *state, const qs_problem *problem, uint16_t *labelling)
{
    for (uint32_t i = 0; i < qs_problem_sites(problem); i++) {
        labelling[i] = (uint16_t)tiny_random(state, problem->labels);
    }
}

/* The least energy when `count` sites, `stride` apart, take labels near `middle`. */
static int64_t least_of_line(const qs_problem *problem, const uint16_t *labelling,
                             const uint16_t *middle, uint32_t first, uint32_t stride,
                             uint32_t count)
{
    uint16_t tried[SITES];
    int64_t least = INT64_MAX;
    uint32_t choices = 1;
    for (uint32_t k = 0; k < count; k++) {
        choices *= 3;
    }
    memcpy(tried, labelling, sizeof tried);
    for (uint32_t choice = 0; choice < choices; choice++) {
        bool exist = true;
        for (uint32_t k = 0, left = choice; k < count; k++, left /= 3) {
            int label = middle[first + k * stride] + (int)(left % 3) - 1;
            exist = exist && label >= 0 && label < (int)problem->labels;
            tried[first + k * stride] = (uint16_t)label;
        }
        int64_t energy = exist ? energy_of(problem, tried) : INT64_MAX;
        least = energy < least ? energy : least;
    }
    return least;
}

static void the_energy_never_rises(void **unused)
{
    (void)unused;
    uint64_t state = 21;
    bool rose_to_other_labels = false;
    for (int round = 0; round < ROUNDS; round++) {
        task given;
        uint16_t start[SITES] = {0}, found[SITES] = {0};
        make_task(&state, &given);
        random_labels(&state, &given.problem, start);
        memcpy(found, start, sizeof found);
        int64_t energy = improve(&given, 1, found);
        assert_true(energy <= energy_of(&given.problem, start));
        for (int i = 0; i < SITES; i++) {
            assert_in_range(found[i] + 1 - start[i], 0, 2);
            rose_to_other_labels |= found[i] != start[i];
        }
        assert_true(improve(&given, 1, found) <= energy);
    }
    assert_true(rose_to_other_labels);
}

/* A single row or column is solved exactly at once. */
static void a_line_is_solved(void **unused)
{
    (void)unused;
    uint64_t state = 22;
    for (int round = 0; round < ROUNDS; round++) {
        task given;
        uint16_t start[SITES] = {0}, found[SITES] = {0};
        make_task(&state, &given);
        qs_grid *grid = &given.problem.grid;
        *(round % 2 == 0 ? &grid->width : &grid->height) = 1;
        uint32_t count = qs_problem_sites(&given.problem);
        random_labels(&state, &given.problem, start);
        memcpy(found, start, sizeof found);
        assert_int_equal(improve(&given, 1, found),
                         least_of_line(&given.problem, start, start, 0, 1, count));
    }
}

/* At the end no row and no column can be changed for the better. */
static void it_goes_on_to_the_end(void **unused)
{
    (void)unused;
    uint64_t state = 23;
    for (int round = 0; round < ROUNDS / 10; round++) {
        task given;
        uint16_t found[SITES] = {0};
        make_task(&state, &given);
        uint32_t width = given.problem.grid.width, height = given.problem.grid.height;
        random_labels(&state, &given.problem, found);
        int64_t energy = improve(&given, UINT32_MAX, found);
        for (uint32_t y = 0; y < height; y++) {
            assert_int_equal(least_of_line(&given.problem, found, found, y * width, 1, width),
                             energy);
        }
        for (uint32_t x = 0; x < width; x++) {
            assert_int_equal(least_of_line(&given.problem, found, found, x, width, height), energy);
        }
    }
}

static void it_refuses_what_does_not_fit(void **unused)
{
    (void)unused;
    uint64_t state = 24;
    task given;
    uint16_t labelling[SITES] = {0};
    qs_solution found;
    make_task(&state, &given);
    const qs_problem good = given.problem;
    size_t size = qs_near_workspace(&good);
    assert_int_equal(qs_near(&good, NULL, memory, size - 1, labelling, &found), QS_E_WORKSPACE);
    assert_int_equal(qs_near(&good, NULL, memory, size, NULL, &found), QS_E_ARGUMENT);
    labelling[0] = (uint16_t)good.labels;
    assert_int_equal(qs_near(&good, NULL, memory, size, labelling, &found), QS_E_ARGUMENT);
    labelling[0] = 0;
    given.problem.source.pick = NULL;
    assert_int_equal(qs_near_workspace(&given.problem), 0);
    assert_int_equal(qs_near(&given.problem, NULL, memory, size, labelling, &found), QS_E_ENCODING);
    given.problem = good;
    given.problem.pairwise.smoothness = QS_TRUNCATED_QUADRATIC;
    assert_int_equal(qs_near(&given.problem, NULL, memory, size, labelling, &found), QS_E_ENCODING);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_energy_never_rises),
        cmocka_unit_test(a_line_is_solved),
        cmocka_unit_test(it_goes_on_to_the_end),
        cmocka_unit_test(it_refuses_what_does_not_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
