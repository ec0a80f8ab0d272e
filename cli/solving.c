#include "solving.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "progress_line.h"
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

static bool is_straight(const laid_out *problem)
{
    return problem->model.sites == 0;
}

static uint32_t sites_of(const laid_out *problem)
{
    return is_straight(problem) ? problem->labels.sites : problem->model.sites;
}

/* Room for the labelling of the model, which has more sites than a masked problem, and for the
 * sample. */
static int take_room(const laid_out *problem, budget *limit, solved *found)
{
    size_t size = sizeof *found->labelling * sites_of(problem);
    found->labelling = budget_take(limit, problem->name, size);
    if (found->labelling == NULL || problem->file == NULL) {
        return found->labelling != NULL ? DONE : NO_RESOURCE;
    }
    found->bits = budget_take(limit, problem->name, ((size_t)problem->variables + 7) / 8);
    return found->bits != NULL ? DONE : NO_RESOURCE;
}

/* Whatever a solver says, the energy that counts is that of the QUBO or the problem. */
static int check_energy(const laid_out *problem, const solved *found, int64_t energy)
{
    char said[DECIMAL_SIZE], given[DECIMAL_SIZE];
    if (energy == found->solution.energy) {
        return DONE;
    }
    decimal_write(found->solution.energy, problem->scale, said);
    decimal_write(energy, problem->scale, given);
    return fail(NO_RESOURCE, problem->name,
                "internal error: %s found the energy %s, but the problem gives it %s; please "
                "report this",
                found->solver, said, given);
}

static int make_sample(const laid_out *problem, solved *found)
{
    const problem_file *file = problem->file;
    qs_status encoded = qs_sample_encode(&file->index, found->labelling, found->bits);
    if (encoded != QS_OK) {
        return fail_status(problem->name, encoded);
    }
    found->qubo_energy = qs_qubo_energy(&file->index, found->bits);
    return check_energy(problem, found,
                        found->qubo_energy + qs_sample_trimmed(&file->qubo, found->labelling));
}

static int check_labelling(const laid_out *problem, budget *work, const solved *found)
{
    int64_t energy = 0;
    size_t size = qs_problem_workspace(problem->problem);
    void *workspace = budget_take(work, problem->name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status known =
        qs_problem_energy(problem->problem, found->labelling, workspace, size, &energy);
    return known == QS_OK ? check_energy(problem, found, energy)
                          : fail_status(problem->name, known);
}

static int check_found(const laid_out *problem, budget *work, solved *found)
{
    qs_model_sites(&problem->model, found->labelling, found->labelling);
    return problem->file != NULL ? make_sample(problem, found)
                                 : check_labelling(problem, work, found);
}

/* A first cycle of moves takes long, and from the cheapest label of each site it begins far off. So
 * where the time is limited, expansion starts from what messages find in a few iterations. */
static bool starts_from_messages(const solver *by, const search *how)
{
    return by->run == qs_expansion && how->time_limit > 0 && how->start == NULL;
}

/* Room for the solver, and for messages before it. */
static size_t workspace_of(const solver *by, const qs_model *model)
{
    size_t size = by->workspace(model),
           first = by->run == qs_expansion ? qs_trws_workspace(model) : 0;
    return first > size ? first : size;
}

static void begin_labelling(const qs_model *model, const uint16_t *start, uint16_t *labelling)
{
    if (start != NULL) {
        memcpy(labelling, start, sizeof *start * model->sites);
    } else {
        qs_model_winner(model, labelling);
    }
}

/* Some solvers begin without a labelling, and may end above the start. */
static void keep_start(const qs_model *model, const uint16_t *start, solved *found)
{
    int64_t energy = start != NULL ? qs_model_energy(model, start) : INT64_MAX;
    if (energy < found->solution.energy) {
        memcpy(found->labelling, start, sizeof *start * model->sites);
        found->solution.energy = energy;
    }
}

/* How the solver is to search. What it points to is borrowed. */
static qs_solve_options options_of(const search *how, progress *watched)
{
    watched->gap = how->gap;
    watched->traced = how->traced;
    return (qs_solve_options){.iterations = how->iterations,
                              .seed = how->seed,
                              .watch = progress_watch,
                              .context = watched,
                              .spent = how->time_limit > 0 ? progress_spent : NULL,
                              .start = how->start,
                              .witness = how->witness};
}

static void take_down(progress *watched, const search *how, solved *found)
{
    found->microseconds = progress_end(watched);
    found->out_of_time = watched->out_of_time;
    found->in_gap = watched->in_gap;
    found->interrupted = watched->interrupted;
    found->own_limit = how->iterations == 0;
}

static void end_trace(const search *how, const solved *found)
{
    trace_end(how->traced, &(trace_point){found->microseconds, found->solution.iterations,
                                          found->solution.energy, found->solution.lower_bound,
                                          TRACE_NO_VARIABLES});
}

/* Runs a solver that takes the problem itself. */
static int run_straight(const laid_out *problem, const solver *by, const search *how, budget *work,
                        solved *found)
{
    size_t size = by->straight_workspace(problem->problem);
    void *workspace = budget_take(work, problem->name, size > 0 ? size : 1);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    progress watched =
        progress_begin(by->name, problem->scale, how->time_limit, how->whole_command);
    trace_begin(how->traced, by->name);
    const qs_solve_options options = options_of(how, &watched);
    progress_keep_on_interrupt(how->keep_on_interrupt);
    qs_status ran = by->run_straight(problem->problem, &options, workspace, size, found->labelling,
                                     &found->solution);
    progress_keep_on_interrupt(false);
    take_down(&watched, how, found);
    if (ran == QS_E_ENCODING || ran == QS_E_OVERFLOW) {
        found->refusal = ran;
        return DONE;
    }
    if (ran != QS_OK) {
        return fail_status(problem->name, ran);
    }
    end_trace(how, found);
    return check_labelling(problem, work, found);
}

/* Checks a first labelling, to see how long that takes. Behind a solver come the same check, the
 * end of its memory and the output, which together take about twice as long, and the end of the
 * command.
 *
 * reserved  out: microseconds that the solver must leave */
static int measure_end(const laid_out *problem, budget *work, solved *found, int64_t *reserved)
{
    enum { TIMES = 2, COMMAND_END = 20000 };
    budget inside = budget_inside(work);
    int64_t begin = progress_clock();
    qs_model_winner(&problem->model, found->labelling);
    found->solution.energy = qs_model_energy(&problem->model, found->labelling);
    int status = check_found(problem, &inside, found);
    budget_free(&inside);
    *reserved = TIMES * (progress_clock() - begin) + COMMAND_END;
    return status;
}

/* The time that the solver has, from the command's beginning or its own. 0 = no limit. */
static int time_of(const laid_out *problem, const search *how, budget *work, solved *found,
                   int64_t *limit)
{
    int64_t reserved = 0;
    *limit = how->time_limit;
    if (how->time_limit > 0 && how->whole_command) {
        TRY(measure_end(problem, work, found, &reserved));
        *limit = reserved < *limit ? *limit - reserved : 1;
    }
    return DONE;
}

/* Starts from the labelling that is known, or else from the cheapest label of each site, if the
 * solver starts from a labelling. `work` is for the solver's workspace. */
static int run_solver(const laid_out *problem, const solver *by, const search *how, budget *work,
                      solved *found)
{
    const char *name = problem->name;
    const qs_model *model = &problem->model;
    bool messages = starts_from_messages(by, how);
    int64_t limit;
    TRY(time_of(problem, how, work, found, &limit));
    size_t size = workspace_of(by, model);
    void *workspace = budget_take(work, name, size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    begin_labelling(model, how->start, found->labelling);
    progress watched = progress_begin(by->name, problem->scale, limit, how->whole_command);
    trace_begin(how->traced, by->name);
    const qs_solve_options options = options_of(how, &watched);
    progress_keep_on_interrupt(how->keep_on_interrupt);
    qs_status ran = QS_OK;
    if (messages) {
        enum { FEW = 4 };
        qs_solve_options few = options;
        few.iterations = FEW;
        few.witness = NULL; /* the proof would be none of expansion */
        ran = qs_trws(model, &few, workspace, size, found->labelling, &found->solution);
    }
    if (ran == QS_OK) {
        ran = by->run(model, &options, workspace, size, found->labelling, &found->solution);
    }
    progress_keep_on_interrupt(false);
    take_down(&watched, how, found);
    if (ran == QS_E_ENCODING || ran == QS_E_OVERFLOW) {
        found->refusal = ran;
        return DONE;
    }
    if (ran != QS_OK) {
        return fail_status(name, ran);
    }
    keep_start(model, how->start, found);
    end_trace(how, found);
    return check_found(problem, work, found);
}

uint64_t solve_bytes(const laid_out *problem, const solver *by)
{
    uint64_t labelling = sizeof(uint16_t) * (uint64_t)sites_of(problem);
    uint64_t check = problem->file != NULL ? ((uint64_t)problem->variables + 7) / 8
                                           : qs_problem_workspace(problem->problem);
    uint64_t work = by->run_straight != NULL ? by->straight_workspace(problem->problem)
                                             : workspace_of(by, &problem->model);
    return bytes_sum(work, labelling + check);
}

int solve_problem(const laid_out *problem, const solver *by, const search *how, budget *limit,
                  solved *found)
{
    memset(found, 0, sizeof *found);
    found->solver = by->name;
    TRY(take_room(problem, limit, found));
    budget work = budget_inside(limit);
    int status = by->run_straight != NULL ? run_straight(problem, by, how, &work, found)
                                          : run_solver(problem, by, how, &work, found);
    budget_free(&work);
    return status;
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

/* Which limit stopped the solver. */
static void print_stop(const solved *found)
{
    if (found->solution.converged) {
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
