/* The solvers as their callers see them, beside every labelling of tiny problems. */
#include "modelled.h"

#include <string.h>

static uint64_t memory[MEMORY / 8];

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
        cmocka_unit_test(every_solver_keeps_its_word),
        cmocka_unit_test(watches_stop),
        cmocka_unit_test(labels_that_are_out_stay_out),
        cmocka_unit_test(labels_stay_out_beside_heavy_edges),
        cmocka_unit_test(small_workspaces_are_refused),
        cmocka_unit_test(icm_ends_in_a_local_minimum),
        cmocka_unit_test(annealing_anneals),
    };
    return cmocka_run_group_tests_name("solve", tests, NULL, NULL);
}
