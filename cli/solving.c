#include "solving.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decimal.h"
#include "gap.h"
#include "json.h"
#include "messages.h"
#include "numbers.h"
#include "progress.h"

static int fail_model(const char *name, qs_status status)
{
    switch (status) {
    case QS_E_UNSUPPORTED:
        return fail(BAD_INPUT, name,
                    "does not say which labels its variables stand for (in a chunk labl), "
                    "which this command needs: qstereo-bridge solves any QUBO");
    case QS_E_CORRUPT:
        return fail(BAD_INPUT, name,
                    "its couplings are not those of the labelling problem that it says it is: "
                    "qstereo-bridge solves any QUBO");
    case QS_E_ENCODING:
        return fail(BAD_INPUT, name,
                    "is a cut of a graph, from which the costs are not read back: this command "
                    "reads one-hot, "
                    "one-hot-sparse and domain-wall, so encode the pair in one of them");
    case QS_E_OVERFLOW:
        return fail(BAD_INPUT, name, "has costs above 2^31 - 1 units, too large for these solvers");
    default: return fail_status(name, status);
    }
}

int laid_out_open(problem_file *problem, budget *limit, laid_out *opened)
{
    memset(opened, 0, sizeof *opened);
    opened->problem = problem;
    if (!problem->qubo.has_labels) {
        return fail_model(problem->name, QS_E_UNSUPPORTED);
    }
    size_t size = qs_model_workspace(&problem->qubo);
    int status = problem_index(problem, limit);
    if (status == DONE) {
        status = budget_allocate(limit, problem->name, size, &opened->workspace);
    }
    if (status != DONE) {
        return status;
    }
    qs_status built = qs_model_build(&problem->index, opened->workspace, size, &opened->model);
    return built == QS_OK ? DONE : fail_model(problem->name, built);
}

void laid_out_close(laid_out *closed)
{
    free(closed->workspace);
    closed->workspace = NULL;
}

/* Room for the labelling of the model, which has more sites than a masked problem, and for the
 * sample. */
static int allocate_found(const laid_out *problem, budget *limit, solved *found)
{
    const problem_file *file = problem->problem;
    void *labelling = NULL, *bits = NULL;
    int status = budget_allocate(limit, file->name, sizeof *found->labelling * problem->model.sites,
                                 &labelling);
    if (status == DONE) {
        status = budget_allocate(limit, file->name, ((size_t)file->qubo.variables + 7) / 8, &bits);
    }
    found->labelling = labelling;
    found->bits = bits;
    return status;
}

/* Whatever a solver says, what counts is what the QUBO gives. */
static int check_energy(const laid_out *problem, solved *found)
{
    const problem_file *file = problem->problem;
    char said[DECIMAL_SIZE], given[DECIMAL_SIZE];
    found->qubo_energy = qs_qubo_energy(&file->index, found->bits);
    int64_t energy = found->qubo_energy + qs_sample_trimmed(&file->qubo, found->labelling);
    if (energy == found->solution.energy) {
        return DONE;
    }
    decimal_write(found->solution.energy, file->scale, said);
    decimal_write(energy, file->scale, given);
    return fail(NO_RESOURCE, file->name,
                "internal error: %s found the energy %s, but the problem gives it %s",
                found->solver, said, given);
}

static int make_sample(const laid_out *problem, solved *found)
{
    const problem_file *file = problem->problem;
    qs_model_sites(&problem->model, found->labelling, found->labelling);
    qs_status encoded = qs_sample_encode(&file->index, found->labelling, found->bits);
    return encoded == QS_OK ? check_energy(problem, found) : fail_status(file->name, encoded);
}

/* From the winner-take-all start, where the solver is one that starts from a labelling. */
static int run_solver(const laid_out *problem, const solver *by, const search *how, budget *limit,
                      solved *found)
{
    const char *name = problem->problem->name;
    void *workspace = NULL;
    size_t size = by->workspace(&problem->model);
    int status = budget_allocate(limit, name, size, &workspace);
    if (status != DONE) {
        return status;
    }
    qs_model_winner(&problem->model, found->labelling);
    progress watched = progress_begin(by->name, problem->problem->scale, how->time_limit);
    const qs_solve_options options = {how->iterations, how->seed, progress_watch, &watched};
    qs_status ran =
        by->run(&problem->model, &options, workspace, size, found->labelling, &found->solution);
    found->microseconds = progress_end(&watched);
    found->out_of_time = watched.out_of_time;
    found->own_limit = how->iterations == 0;
    free(workspace);
    if (ran == QS_E_ENCODING || ran == QS_E_OVERFLOW) {
        found->refusal = ran;
        return DONE;
    }
    return ran == QS_OK ? make_sample(problem, found) : fail_status(name, ran);
}

int solve_problem(const laid_out *problem, const solver *by, const search *how, budget limit,
                  solved *found)
{
    memset(found, 0, sizeof *found);
    found->solver = by->name;
    int status = allocate_found(problem, &limit, found);
    if (status == DONE) {
        status = run_solver(problem, by, how, &limit, found);
    }
    if (status != DONE) {
        solved_free(found);
    }
    return status;
}

void solved_free(solved *freed)
{
    free(freed->labelling);
    free(freed->bits);
    freed->labelling = NULL;
    freed->bits = NULL;
}

int solved_check(const laid_out *problem, const solved *found)
{
    const char *name = problem->problem->name;
    if (found->refusal == QS_E_ENCODING) {
        return fail(
            BAD_INPUT, name, "%s cannot be used with this pairwise cost (%s); use trws, bp or best",
            found->solver, name_of(&smoothness_names, (int)problem->model.pairwise.smoothness));
    }
    if (found->refusal == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name, "its costs are too large for %s", found->solver);
    }
    return DONE;
}

bool solved_has_bound(const solved *found)
{
    return found->solution.lower_bound != QS_NO_BOUND;
}

bool solved_is_proven(const solved *found)
{
    return solved_has_bound(found) && found->solution.lower_bound == found->solution.energy;
}

void solved_json(const solved *found, uint32_t scale)
{
    const qs_solution *solution = &found->solution;
    json_name("solver", found->solver);
    json_units("energy", solution->energy, scale);
    if (solved_has_bound(found)) {
        json_units("lower_bound", solution->lower_bound, scale);
        json_units("gap", solution->energy - solution->lower_bound, scale);
    } else {
        json_null("lower_bound");
        json_null("gap");
    }
    json_truth("proven_optimal", solved_is_proven(found));
    json_count("iterations", solution->iterations);
    json_units("seconds", found->microseconds, 1000000);
    json_truth("converged", solution->converged);
}

static void print_bound(const solved *found, uint32_t scale)
{
    char bound[DECIMAL_SIZE], gap[GAP_SIZE];
    if (solved_is_proven(found)) {
        fputs(", proven optimal", stdout);
    } else if (solved_has_bound(found)) {
        decimal_write(found->solution.lower_bound, scale, bound);
        gap_write(found->solution.energy, found->solution.lower_bound, scale, gap);
        printf(", lower bound %s, gap %s", bound, gap);
    } else {
        printf("; %s has no lower bound", found->solver);
    }
}

/* Which limit it was that stopped a solver. */
static void print_stop(const solved *found)
{
    if (found->solution.converged) {
        return;
    }
    if (found->out_of_time) {
        fputs(", stopped at the time limit", stdout);
    } else {
        printf(", stopped at %s limit of %" PRIu64 " iteration%s",
               found->own_limit ? "its own" : "the", found->solution.iterations,
               plural(found->solution.iterations));
    }
}

void solved_print(const solved *found, uint32_t scale)
{
    char energy[DECIMAL_SIZE];
    decimal_write(found->solution.energy, scale, energy);
    printf("energy %s by %s", energy, found->solver);
    print_bound(found, scale);
    printf("\n%" PRIu64 " iteration%s, %.3f s", found->solution.iterations,
           plural(found->solution.iterations), (double)found->microseconds / 1e6);
    print_stop(found);
    putchar('\n');
}
