#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "comparison.h"
#include "json_check.h"
#include "map_output.h"
#include "messages.h"
#include "options.h"
#include "solving.h"
#include "survey.h"

enum {
    SOLVER_LIST,
    SAMPLES,
    SEARCH,
    TRUTH = SEARCH + SEARCH_OPTIONS,
    TRUTH_SCALE,
    MAPS,
    SCALE,
    JSON,
    MEMORY_LIMIT
};

static const option options[] = {
    [SOLVER_LIST] = {"solvers", 0, false, "NAMES", "icm,anneal,swap,expansion,bp,trws,best",
                     "the solvers to run, with commas between"},
    [SAMPLES] = {"samples", 0, false, "S.qsf", NULL,
                 "add the best feasible sample of this file; may be given again"},
    [SEARCH] = SEARCH_OPTION_ROWS,
    [TRUTH] = TRUTH_OPTION,
    [TRUTH_SCALE] = TRUTH_SCALE_OPTION,
    [MAPS] = {"maps", 0, false, "DIR", NULL,
              "write each map as DIR/SOLVER.png (.pgm in a build without OpenCV)"},
    [SCALE] = SCALE_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "compare",
    .operands = {"P.qcf"},
    .about = "Runs solvers on one problem, adds the samples of others (a QPU, hybrids), and prints "
             "for each its energy, the\n"
             "gap to the best lower bound of all, its feasible samples, the errors against the "
             "truth, and the seconds. A\n"
             "solver that cannot be used with the pairwise cost is shown as such.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo compare p.qcf --truth truth.png --truth-scale 8\n"
                "  qstereo compare p.qcf --samples qpu.qsf --samples hybrid.qsf --solvers "
                "expansion,trws,best --json\n"
                "  qstereo compare p.qcf --time-limit 5 --maps maps\n",
};

typedef struct request {
    const solver *by[RESULTS_MAX];
    size_t solver_count;
    search how;
    const char *truth, *maps; /* NULL = none */
    uint32_t truth_scale, scale;
    bool json;
} request;

/* The work under way. */
typedef struct comparing {
    const request *asked;
    answer both; /* the samples are those of the moment */
    laid_out laid;
    budget limit; /* what the problem has left */
    true_map truth;
    output outs[RESULTS_MAX];
    size_t out_count;
    comparison table;
} comparing;

static int read_solvers(const char *text, request *asked)
{
    for (;;) {
        size_t length = strcspn(text, ",");
        if (asked->solver_count == RESULTS_MAX) {
            return fail_usage("--solvers: more than %d", RESULTS_MAX);
        }
        int status = solvers_read(text, length, &asked->by[asked->solver_count++]);
        if (status != DONE || text[length] == '\0') {
            return status;
        }
        text += length + 1;
    }
}

static int read_request(const arguments *given, request *asked)
{
    const char *const *values = given->values;
    memset(asked, 0, sizeof *asked);
    asked->truth = values[TRUTH];
    asked->maps = values[MAPS];
    asked->json = values[JSON] != NULL;
    int status = read_solvers(values[SOLVER_LIST], asked);
    if (status == DONE) {
        status = search_read(&values[SEARCH], &asked->how);
    }
    if (status == DONE) {
        status = truth_scale_read(values[TRUTH_SCALE], &asked->truth_scale);
    }
    return status == DONE ? map_scale_read(values[SCALE], &asked->scale) : status;
}

/* Whether an earlier result has a map of this name. */
static bool is_taken(const comparison *table, const char *name)
{
    for (size_t i = 0; i < table->count; i++) {
        if (table->results[i].map != NULL && strcmp(table->results[i].map, name) == 0) {
            return true;
        }
    }
    return false;
}

static map_format map_format_here(void)
{
    return picture_library_writes_png() ? MAP_PNG : MAP_PGM;
}

/* DIR/SOLVER.png, where a letter of the solver's name that would be awkward in a file's becomes _,
 * and a name that is there already gets a number. */
static int name_map(comparing *at, result *of)
{
    char stem[sizeof of->solver];
    size_t size = strlen(at->asked->maps) + sizeof stem + 32;
    char *name = malloc(size);
    if (name == NULL) {
        return fail_memory(at->asked->maps);
    }
    for (size_t i = 0; i < sizeof stem; i++) {
        unsigned char c = (unsigned char)of->solver[i];
        stem[i] =
            (char)(c == '\0' || isalnum(c) || strchr("-_", c) != NULL || (c == '.' && i > 0) ? c
                                                                                             : '_');
    }
    const char *ending = map_format_here() == MAP_PNG ? "png" : "pgm";
    (void)snprintf(name, size, "%s/%s.%s", at->asked->maps, stem, ending);
    for (unsigned number = 2; is_taken(&at->table, name); number++) {
        (void)snprintf(name, size, "%s/%s-%u.%s", at->asked->maps, stem, number, ending);
    }
    of->map = name;
    return DONE;
}

static int add_result(comparing *at, const char *name, size_t size, result **added)
{
    int status = comparison_add(&at->table, name, size, added);
    return status == DONE && at->asked->maps != NULL ? name_map(at, *added) : status;
}

static int write_map(comparing *at, result *of, const pixel_map *map)
{
    file_bytes file = {NULL, 0};
    int status = map_encode(map, map_format_here(), at->asked->scale, of->map, &file);
    if (status == DONE) {
        status = output_open(&at->outs[at->out_count], of->map);
    }
    if (status == DONE) {
        (void)output_write(&at->outs[at->out_count++], file.bytes,
                           file.size); /* a refusal is reported by the commit */
        of->has_map = true;
    }
    file_free(&file);
    return status;
}

/* What the labelling of a result looks like as a map, where that is asked for. */
static int look_at_map(comparing *at, result *of, const uint16_t *labelling, budget limit)
{
    uint32_t *disparities = NULL;
    pixel_map map;
    if (at->asked->truth == NULL && at->asked->maps == NULL) {
        return DONE;
    }
    int status = map_of_labelling(&at->both.problem, labelling, &limit, &disparities, &map);
    if (status == DONE && at->asked->truth != NULL) {
        status = truth_compare(&at->truth, &map, &of->errors);
    }
    if (status == DONE && at->asked->maps != NULL) {
        status = write_map(at, of, &map);
    }
    free(disparities);
    return status;
}

static int run_solver(comparing *at, const solver *by, result *of)
{
    solved found;
    int status = solve_problem(&at->laid, by, &at->asked->how, at->limit, &found);
    if (status != DONE) {
        return status;
    }
    of->refusal = found.refusal;
    if (found.refusal == QS_OK) {
        of->feasible = of->samples = 1;
        of->energy = found.solution.energy;
        of->lower_bound = found.solution.lower_bound;
        of->microseconds = found.microseconds;
        status = look_at_map(at, of, found.labelling, at->limit);
    }
    solved_free(&found);
    return status;
}

static int look_at_sample(comparing *at, result *of, uint32_t sample, budget limit)
{
    const answer *both = &at->both;
    void *labelling = NULL;
    int status = budget_allocate(&limit, both->problem.name,
                                 sizeof(uint16_t) * both->problem.qubo.labels.sites, &labelling);
    if (status != DONE) {
        return status;
    }
    const uint8_t *bits = qs_samples_bits(&both->samples.view, sample);
    qs_status decoded = qs_sample_decode(&both->problem.index, bits, labelling);
    status = decoded == QS_OK ? look_at_map(at, of, labelling, limit)
                              : fail_status(both->samples.name, decoded);
    free(labelling);
    return status;
}

/* The seconds that the file itself states, as those of qstereo solve do. */
static int64_t stated_microseconds(const qs_samples_view *samples)
{
    double seconds;
    bool known = json_find_number(samples->info, samples->info_size, "seconds", &seconds);
    return known && seconds >= 0 && seconds < 1e12 ? (int64_t)(seconds * 1e6 + 0.5) : -1;
}

static int add_answer(comparing *at, budget limit)
{
    const qs_samples_view *samples = &at->both.samples.view;
    result *of;
    survey seen;
    int status = survey_samples(&at->both, limit, &seen);
    if (status == DONE) {
        status = survey_fail_wrong(&at->both, &seen);
    }
    if (status == DONE) {
        status = add_result(at, samples->solver, samples->solver_size, &of);
    }
    if (status != DONE) {
        return status;
    }
    of->samples = samples->count;
    of->feasible = seen.feasible;
    of->energy = seen.best_energy;
    of->microseconds = stated_microseconds(samples);
    return seen.feasible > 0 ? look_at_sample(at, of, seen.best, limit) : DONE;
}

static int add_samples(comparing *at, const char *path)
{
    budget limit = at->limit;
    int status = answer_open_samples(&at->both, path, &limit);
    if (status == DONE) {
        status = add_answer(at, limit);
        answer_close_samples(&at->both);
    }
    return status;
}

/* The solvers stand first, but what is wrong with a samples file is to be known before they run. */
static int fill_table(comparing *at, const arguments *given)
{
    const request *asked = at->asked;
    size_t next = 0;
    result *added;
    int status = DONE;
    for (size_t i = 0; i < asked->solver_count && status == DONE; i++) {
        status = add_result(at, asked->by[i]->name, strlen(asked->by[i]->name), &added);
    }
    for (const char *path;
         status == DONE && (path = options_next(given, SAMPLES, &next)) != NULL;) {
        status = add_samples(at, path);
    }
    for (size_t i = 0; i < asked->solver_count && status == DONE; i++) {
        status = run_solver(at, asked->by[i], &at->table.results[i]);
    }
    return status;
}

/* Opens what the options name. */
static int open_options(comparing *at)
{
    const request *asked = at->asked;
    const problem_file *problem = &at->both.problem;
    const qs_frame *frame = &problem->qubo.labels.frame;
    int status = DONE;
    if (asked->truth != NULL || asked->maps != NULL) {
        status = map_check_grid(problem);
    }
    if (status == DONE && asked->truth != NULL) {
        status = truth_open(asked->truth, asked->truth_scale, frame->picture_width,
                            frame->picture_height, &at->truth);
    }
    return status == DONE && asked->maps != NULL ? output_make_folder(asked->maps) : status;
}

static void abandon_maps(comparing *at)
{
    while (at->out_count > 0) {
        output_abandon(&at->outs[--at->out_count]);
    }
    output_drop_folder();
}

static int compare(comparing *at, const arguments *given)
{
    int status = laid_out_open(&at->both.problem, &at->limit, &at->laid);
    at->table.scale = at->both.problem.scale;
    at->table.scored = at->asked->truth != NULL;
    if (status == DONE) {
        status = open_options(at);
    }
    if (status == DONE) {
        status = fill_table(at, given);
    }
    if (status == DONE) {
        (at->asked->json ? comparison_json : comparison_print)(&at->table);
        status = output_commit(at->outs, at->out_count);
        at->out_count = 0;
    }
    if (status == DONE) {
        output_keep_folder();
    } else {
        abandon_maps(at);
    }
    comparison_free(&at->table);
    truth_close(&at->truth);
    laid_out_close(&at->laid);
    return status;
}

int cmd_compare(int argc, char **argv)
{
    arguments given;
    request asked;
    comparing at;
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    memset(&at, 0, sizeof at);
    at.asked = &asked;
    status = budget_read(given.values[MEMORY_LIMIT], &at.limit);
    if (status == DONE) {
        status = read_request(&given, &asked);
    }
    if (status == DONE) {
        status = problem_open(given.operands[0], &at.limit, &at.both.problem);
    }
    if (status == DONE) {
        status = compare(&at, &given);
        problem_close(&at.both.problem);
    }
    return status;
}
