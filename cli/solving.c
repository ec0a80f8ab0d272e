#include "solving.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"

int search_read(const char *const *values, search *asked)
{
    const char *time_limit = values[SEARCH_TIME_LIMIT], *iterations = values[SEARCH_ITERATIONS];
    memset(asked, 0, sizeof *asked);
    asked->gap = -1;
    TRY(number64_read("--seed", values[SEARCH_SEED], 0, UINT64_MAX, &asked->seed));
    if (time_limit != NULL) {
        TRY(seconds_read("--time-limit", time_limit, &asked->time_limit));
    }
    if (iterations != NULL) {
        TRY(number64_read("--iterations", iterations, 1, UINT64_MAX, &asked->iterations));
    }
    return DONE;
}

static const solver solvers[] = {
    {"icm", qs_icm, qs_icm_workspace, NULL, NULL, NULL},
    {"anneal", qs_anneal, qs_anneal_workspace, NULL, NULL, NULL},
    {"swap", qs_swap, qs_swap_workspace, NULL, NULL, NULL},
    {"expansion", qs_expansion, qs_expansion_workspace, NULL, NULL, NULL},
    {"bp", qs_bp, qs_bp_workspace, NULL, NULL, NULL},
    {"trws", qs_trws, qs_trws_workspace, NULL, NULL, NULL},
    {"cut", qs_min_cut, qs_min_cut_workspace, NULL, NULL,
     "linear or quadratic smoothness without truncation, Potts with two labels, or a submodular "
     "table"},
    {"pack", qs_pack, qs_pack_workspace, NULL, NULL,
     "two labels and one table for all edges, in which two neighbours that both take label 1 cost "
     "more, as boxes that overlap do"},
    {"best", qs_best, qs_best_workspace, NULL, NULL, NULL},
    {"trws16", NULL, NULL, qs_trws16, qs_trws16_workspace,
     "Potts or linear smoothness on a grid without masked cells"},
};
enum {
    ALL_SOLVERS = sizeof solvers / sizeof solvers[0],
    SOLVERS = ALL_SOLVERS - 1 /* those that any problem can be given to */
};

const char *solver_at(size_t index)
{
    return index < SOLVERS ? solvers[index].name : NULL;
}

static int read_name(const char *what, const char *text, size_t count, const solver **chosen)
{
    named names[ALL_SOLVERS];
    int index = 0;
    for (size_t i = 0; i < count; i++) {
        names[i] = (named){solvers[i].name, (int)i};
    }
    const name_table table = {what, names, count, count};
    TRY(name_read(&table, text, "", &index));
    *chosen = &solvers[index];
    return DONE;
}

int solver_read(const char *text, const solver **chosen)
{
    return read_name("solver", text, SOLVERS, chosen);
}

int pair_solver_read(const char *text, const solver **chosen)
{
    return read_name("solver", text, ALL_SOLVERS, chosen);
}

int solvers_read(const char *text, size_t length, const solver **chosen)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%.*s", length < sizeof name ? (int)length : (int)sizeof name,
                   text);
    return read_name("solvers", name, SOLVERS, chosen);
}

static int fail_cut(const char *name)
{
    char list[ENCODING_LIST_SIZE];
    encodings_with_model_write(list);
    return fail(BAD_INPUT, name,
                "is a cut of a graph, from which the costs cannot be read back: for this command "
                "encode the pair in one of these encodings: %s",
                list);
}

int stopping_read(const char *const *values, search *asked)
{
    const char *gap = values[STOPPING_GAP_LIMIT];
    asked->whole_command = true;
    asked->keep_on_interrupt = values[STOPPING_KEEP] != NULL;
    return gap != NULL ? percent_read("--gap-limit", gap, &asked->gap) : DONE;
}

static int fail_model(const char *name, qs_status status)
{
    switch (status) {
    case QS_E_UNSUPPORTED:
        return fail(BAD_INPUT, name,
                    "does not say which labels its variables stand for (chunk labl), which this "
                    "command needs: solve it with qstereo-bridge, which takes any QUBO");
    case QS_E_CORRUPT:
        return fail(BAD_INPUT, name,
                    "its couplings are not those of the labelling problem that it says it is: "
                    "solve it with qstereo-bridge, which takes any QUBO");
    case QS_E_ENCODING: return fail_cut(name);
    case QS_E_OVERFLOW:
        return fail(BAD_INPUT, name,
                    "has costs above 2^31 - 1 units, too large for these solvers: encode the pair "
                    "with fewer decimals in --lambda, or with a smaller --lambda");
    default: return fail_status(name, status);
    }
}

int lay_out(problem_file *problem, budget *limit, laid_out *made)
{
    memset(made, 0, sizeof *made);
    if (!problem->qubo.has_labels) {
        return fail_model(problem->name, QS_E_UNSUPPORTED);
    }
    made->name = problem->name;
    made->scale = problem->scale;
    made->variables = problem->qubo.variables;
    made->labels = problem->qubo.labels;
    made->file = problem;
    TRY(problem_index(problem, limit));
    size_t size = qs_model_workspace(&problem->qubo);
    void *workspace = budget_take(limit, problem->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status built = qs_model_build(&problem->index, workspace, size, &made->model);
    return built == QS_OK ? DONE : fail_model(problem->name, built);
}

const char *fewer_decimals(const char *mend, uint32_t scale)
{
    return scale > 1 && strstr(mend, "--lambda") != NULL ? "give --lambda fewer decimals, or " : "";
}

int lay_out_problem(const char *name, const qs_problem *problem, const char *mend, budget *limit,
                    laid_out *made)
{
    memset(made, 0, sizeof *made);
    size_t size = qs_model_of_problem_workspace(problem);
    void *workspace = budget_take(limit, name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status built = qs_model_of_problem(problem, workspace, size, &made->model, &made->labels);
    if (built == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name,
                    "its costs overflow what the solvers can hold: %schoose a smaller %s",
                    fewer_decimals(mend, problem->scale), mend);
    }
    made->name = name;
    made->scale = made->labels.scale;
    made->variables = (uint64_t)made->labels.sites * made->labels.labels;
    made->problem = problem;
    return built == QS_OK ? DONE : fail_status(name, built);
}

int lay_out_straight(const char *name, const qs_problem *problem, laid_out *made)
{
    memset(made, 0, sizeof *made);
    qs_status status = qs_labels_of_problem(problem, &made->labels);
    made->name = name;
    made->scale = made->labels.scale;
    made->variables = (uint64_t)made->labels.sites * made->labels.labels;
    made->problem = problem;
    return status == QS_OK ? DONE : fail_status(name, status);
}

/* Writes the names of the solvers that take any problem: "icm, anneal, best". */
static void write_general(char *list, size_t size)
{
    size_t used = 0;
    list[0] = '\0';
    for (size_t i = 0; i < SOLVERS && used < size; i++) {
        if (solvers[i].needs == NULL) {
            int more =
                snprintf(list + used, size - used, "%s%s", used > 0 ? ", " : "", solvers[i].name);
            used += more > 0 ? (size_t)more : size;
        }
    }
}

int solved_check(const laid_out *problem, const solver *by, const solved *found)
{
    char general[128];
    write_general(general, sizeof general);
    if (found->refusal == QS_E_ENCODING) {
        const qs_pairwise *pairwise = &problem->labels.pairwise;
        return fail_usage("--solver %s cannot solve the problem of %s (%s%s, %" PRIu32 " label%s): "
                          "it needs %s; these take any problem: %s",
                          by->name, problem->name, pairwise->truncation > 0 ? "truncated " : "",
                          name_of(&smoothness_names, (int)pairwise->smoothness),
                          problem->labels.labels, plural(problem->labels.labels), by->needs,
                          general);
    }
    if (found->refusal == QS_E_OVERFLOW) {
        return fail_usage("--solver %s cannot solve the problem of %s, whose costs are too large "
                          "for it: choose fewer decimals in the costs, each of which multiplies "
                          "all of them by 10, or one of %s",
                          by->name, problem->name, general);
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

/* 0 if there is no bound. */
static int64_t solved_gap(const solved *found)
{
    return solved_has_bound(found) ? found->solution.energy - found->solution.lower_bound : 0;
}

void solved_json(const solved *found, uint32_t scale)
{
    const qs_solution *solution = &found->solution;
    json_name("solver", found->solver);
    json_units("energy", solution->energy, scale);
    json_units_or_null("lower_bound", solved_has_bound(found), solution->lower_bound, scale);
    json_units_or_null("gap", solved_has_bound(found), solved_gap(found), scale);
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

/* Which limit stopped the solver, or why it ended without a proof. */
static void print_stop(const solved *found)
{
    if (found->solution.converged) {
        bool open = solved_has_bound(found) && !solved_is_proven(found);
        fputs(open ? ", ended because nothing more was gained" : "", stdout);
        return;
    }
    if (found->interrupted) {
        fputs(", interrupted", stdout);
    } else if (found->out_of_time) {
        fputs(", stopped at the time limit", stdout);
    } else if (found->in_gap) {
        fputs(", stopped at the gap limit", stdout);
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
