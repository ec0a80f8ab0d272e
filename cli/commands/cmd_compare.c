#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "comparison.h"
#include "known_best.h"
#include "meaning_output.h"
#include "pictures/disparity_map.h"
#include "pictures/picture_library.h"
#include "solving.h"
#include "survey.h"
#include "text/fail.h"
#include "text/json.h"

enum {
    SOLVER_LIST,
    SAMPLES,
    SEARCH,
    TRUTH = SEARCH + SEARCH_OPTIONS,
    TRUTH_SCALE,
    TRUTH_NO_VALUE,
    MAPS,
    SCALE,
    TRACE,
    JSON,
    MEMORY_LIMIT
};

static const option options[] = {
    [SOLVER_LIST] = {"solvers", 0, false, "NAMES", "icm,anneal,swap,expansion,bp,trws,best",
                     "solvers to run, separated by commas"},
    [SAMPLES] = {"samples", 0, false, "S.qsf", NULL,
                 "add the best feasible sample of this file; may be given several times"},
    [SEARCH] = SEARCH_OPTION_ROWS,
    [TRUTH] = TRUTH_OPTION,
    [TRUTH_SCALE] = TRUTH_SCALE_OPTION,
    [TRUTH_NO_VALUE] = TRUTH_NO_VALUE_OPTION,
    [MAPS] = {"maps", 0, false, "DIR", NULL,
              "write each map as DIR/SOLVER.png (.pgm in a build without OpenCV; .pfm where "
              "disparities can be below 0)"},
    [SCALE] = SCALE_OPTION,
    [TRACE] = TRACE_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct request {
    const solver *by[RESULTS_MAX];
    size_t solver_count;
    search how;
    const char *truth, *maps; /* NULL = none */
    uint32_t scale;
    map_form truth_form;
} request;

/* A comparison under way. */
typedef struct comparing {
    job *at; /* its samples are those of the moment */
    request asked;
    laid_out laid;
    true_map truth;
    comparison table;
    trace course; /* of all solvers, one after the other */
} comparing;

static int read_solvers(const char *text, request *asked)
{
    for (;;) {
        size_t length = strcspn(text, ",");
        if (asked->solver_count == RESULTS_MAX) {
            return fail_usage("--solvers: %d solvers are the most", RESULTS_MAX);
        }
        TRY(solvers_read(text, length, &asked->by[asked->solver_count++]));
        if (text[length] == '\0') {
            return DONE;
        }
        text += length + 1;
    }
}

static int read_request(const char *const *values, request *asked)
{
    asked->truth = values[TRUTH];
    asked->maps = values[MAPS];
    TRY(read_solvers(values[SOLVER_LIST], asked));
    TRY(search_read(&values[SEARCH], &asked->how));
    TRY(truth_form_read(values[TRUTH_SCALE], values[TRUTH_NO_VALUE], &asked->truth_form));
    return map_scale_read(values[SCALE], &asked->scale);
}

/* Returns true if an earlier result has a map of this name. */
static bool is_taken(const comparison *table, const char *name)
{
    for (size_t i = 0; i < table->count; i++) {
        if (table->results[i].map != NULL && strcmp(table->results[i].map, name) == 0) {
            return true;
        }
    }
    return false;
}

static const qs_labels *labels_of(const comparing *with)
{
    return &with->at->both.problem.qubo.labels;
}

/* Of disparities below 0 only floats hold a map. */
static map_format map_format_here(const comparing *with)
{
    return labels_of(with)->frame.first < 0 ? MAP_PFM
           : picture_library_writes_png()   ? MAP_PNG
                                            : MAP_PGM;
}

/* With a number and an ending the name of a file must not pass the usual limit of 255 bytes. */
enum { STEM_SIZE = 201 };

/* Names the map DIR/SOLVER.png. A letter that would be awkward in the name of a file becomes _, a
 * long name is cut, and a name that is taken gets a number. */
static int name_map(comparing *with, result *of)
{
    char stem[STEM_SIZE];
    size_t size = strlen(with->asked.maps) + sizeof stem + 32;
    char *name = budget_take(&with->at->limit, with->asked.maps, size);
    if (name == NULL) {
        return NO_RESOURCE;
    }
    stem[STEM_SIZE - 1] = '\0';
    for (size_t i = 0; i + 1 < sizeof stem; i++) {
        char c = of->solver[i];
        bool fits = c == '\0' || isalnum((unsigned char)c) || strchr("-_", c) != NULL ||
                    (c == '.' && i > 0);
        stem[i] = (char)(fits ? c : '_');
    }
    const char *ending =
        map_format_here(with) == MAP_PFM ? "pfm" : meaning_output_ending(labels_of(with));
    (void)snprintf(name, size, "%s/%s.%s", with->asked.maps, stem, ending);
    for (unsigned number = 2; is_taken(&with->table, name); number++) {
        (void)snprintf(name, size, "%s/%s-%u.%s", with->asked.maps, stem, number, ending);
    }
    of->map = name;
    return DONE;
}

static int add_result(comparing *with, const char *name, size_t size, result **added)
{
    TRY(comparison_add(&with->table, name, size, added));
    return with->asked.maps != NULL ? name_map(with, *added) : DONE;
}

static int write_map(comparing *with, result *of, const pixel_map *map)
{
    output *out;
    TRY(job_open_output(with->at, of->map, &out));
    of->has_map = true;
    return map_write(map, map_format_here(with), with->asked.scale, of->map, out);
}

/* The same for labels that are no disparities. */
static int write_other(comparing *with, result *of, const uint16_t *labelling, budget *work)
{
    const char *name = with->at->both.problem.name;
    meaning_output as;
    output *out;
    TRY(meaning_output_read(name, labels_of(with), of->map, &as));
    TRY(job_open_output(with->at, of->map, &out));
    of->has_map = true;
    return meaning_output_write(name, labels_of(with), labelling, &as, work, out);
}

/* Makes the map of a labelling, if the truth or the maps ask for it: its errors, and its file. */
static int look_at_map(comparing *with, result *of, const uint16_t *labelling, budget *work)
{
    const problem_file *problem = &with->at->both.problem;
    pixel_map map;
    if (with->asked.truth == NULL && with->asked.maps == NULL) {
        return DONE;
    }
    if (labels_of(with)->meaning.kind != QS_MEANS_DISPARITY) {
        return write_other(with, of, labelling, work);
    }
    TRY(map_of_labelling(problem->name, &problem->qubo.labels, labelling, work, &map));
    if (with->asked.truth != NULL) {
        TRY(truth_compare(&with->truth, &map, &of->errors));
    }
    return with->asked.maps != NULL ? write_map(with, of, &map) : DONE;
}

static int run_solver(comparing *with, const solver *by, result *of, budget *work)
{
    solved found;
    TRY(solve_problem(&with->laid, by, &with->asked.how, work, &found));
    of->refusal = found.refusal;
    if (found.refusal != QS_OK) {
        return DONE;
    }
    of->feasible = of->samples = 1;
    of->energy = found.solution.energy;
    of->lower_bound = found.solution.lower_bound;
    of->microseconds = found.microseconds;
    return look_at_map(with, of, found.labelling, work);
}

static int look_at_sample(comparing *with, result *of, uint32_t sample, budget *work)
{
    const answer *both = &with->at->both;
    const uint8_t *bits = qs_samples_bits(&both->samples.view, sample);
    uint16_t *labelling =
        budget_take(work, both->problem.name, sizeof *labelling * both->problem.qubo.labels.sites);
    if (labelling == NULL) {
        return NO_RESOURCE;
    }
    qs_status decoded = qs_sample_decode(&both->problem.index, bits, labelling);
    return decoded == QS_OK ? look_at_map(with, of, labelling, work)
                            : fail_status(both->samples.name, decoded);
}

/* The seconds that the file states, as the files of qstereo solve do; -1 = it does not. */
static int64_t stated_microseconds(const qs_samples_view *samples)
{
    double seconds;
    bool known = json_find_number(samples->info, samples->info_size, "seconds", &seconds);
    return known && seconds >= 0 && seconds < 1e12 ? (int64_t)(seconds * 1e6 + 0.5) : -1;
}

static int add_samples(comparing *with, const char *path, budget *work)
{
    answer *both = &with->at->both;
    const qs_samples_view *samples = &both->samples.view;
    result *of;
    survey seen;
    TRY(answer_open_samples(both, path, work));
    TRY(survey_samples(both, work, &seen));
    TRY(survey_fail_wrong(both, &seen));
    TRY(add_result(with, samples->solver, samples->solver_size, &of));
    of->file = path;
    of->samples = samples->count;
    of->feasible = seen.feasible;
    of->energy = seen.best_energy;
    of->microseconds = stated_microseconds(samples);
    return seen.feasible > 0 ? look_at_sample(with, of, seen.best, work) : DONE;
}

static int add_files(comparing *with)
{
    size_t next = 0;
    const char *path = options_next(with->at->given, SAMPLES, &next);
    while (path != NULL) {
        budget work = budget_inside(&with->at->limit);
        int status = add_samples(with, path, &work);
        budget_free(&work);
        TRY(status);
        path = options_next(with->at->given, SAMPLES, &next);
    }
    return DONE;
}

static int run_solvers(comparing *with)
{
    for (size_t i = 0; i < with->asked.solver_count; i++) {
        budget work = budget_inside(&with->at->limit);
        int status = run_solver(with, with->asked.by[i], &with->table.results[i], &work);
        budget_free(&work);
        TRY(status);
    }
    return DONE;
}

/* The labelling that the problem's file carries is a row of its own: solvers that began with it
 * would all look as good. */
static int add_known(comparing *with)
{
    const problem_file *problem = &with->at->both.problem;
    static const char name[] = "known";
    known_best known;
    result *of;
    TRY(known_best_open(problem, &with->at->limit, &known));
    if (known.labelling == NULL) {
        return DONE;
    }
    TRY(add_result(with, name, sizeof name - 1, &of));
    of->samples = of->feasible = 1;
    of->energy = known.energy;
    return look_at_map(with, of, known.labelling, &with->at->limit);
}

/* The rows of the solvers come first, but the samples files are read before the solvers run, so
 * that a bad file is found at once. */
static int fill_table(comparing *with)
{
    const request *asked = &with->asked;
    result *added;
    for (size_t i = 0; i < asked->solver_count; i++) {
        TRY(add_result(with, asked->by[i]->name, strlen(asked->by[i]->name), &added));
    }
    TRY(add_known(with));
    TRY(add_files(with));
    return run_solvers(with);
}

/* Opens what the options name. */
static int open_options(comparing *with)
{
    const request *asked = &with->asked;
    const problem_file *problem = &with->at->both.problem;
    const qs_frame *frame = &problem->qubo.labels.frame;
    bool disparities = problem->qubo.labels.meaning.kind == QS_MEANS_DISPARITY;
    if (asked->truth != NULL && !disparities) {
        return fail(BAD_INPUT, problem->name,
                    "has labels that are no disparities, which --truth is for: write them with "
                    "--maps and use qstereo score --as");
    }
    if (disparities && (asked->truth != NULL || asked->maps != NULL)) {
        TRY(map_check(problem->name, &problem->qubo.labels, map_format_here(with)));
    }
    if (asked->truth != NULL) {
        TRY(truth_open(asked->truth, &asked->truth_form, frame->picture_width,
                       frame->picture_height, &with->at->limit, &with->truth));
    }
    return asked->maps != NULL ? output_make_folder(asked->maps) : DONE;
}

/* Finds out before the work whether there is memory for each solver, and for a map after it. */
static int check_memory(const comparing *with)
{
    const request *asked = &with->asked;
    const map_request maps = {.format = map_format_here(with)};
    uint64_t most = 0;
    for (size_t i = 0; i < asked->solver_count; i++) {
        uint64_t bytes = solve_bytes(&with->laid, asked->by[i], asked->how.iterations);
        most = bytes > most ? bytes : most;
    }
    if (asked->maps != NULL || asked->truth != NULL) {
        uint64_t sites = with->laid.model.sites;
        uint64_t map = bytes_sum(map_bytes(&maps, &with->laid.labels), 2 * sites);
        most = map > most ? map : most;
    }
    return budget_need(&with->at->limit, with->laid.name, most);
}

static int compare(comparing *with)
{
    job *at = with->at;
    TRY(read_request(at->values, &with->asked));
    TRY(job_open_problem(at));
    TRY(lay_out(&at->both.problem, &at->limit, &with->laid));
    with->table.scale = at->both.problem.scale;
    with->table.scored = with->asked.truth != NULL;
    TRY(open_options(with));
    TRY(check_memory(with));
    TRY(trace_open(at, at->values[TRACE], with->laid.scale, &with->course));
    with->asked.how.traced = &with->course;
    with->table.trace = at->values[TRACE];
    TRY(fill_table(with));
    TRY(job_commit(at));
    (at->json ? comparison_json : comparison_print)(&with->table);
    return DONE;
}

static int run_compare(job *at)
{
    comparing with;
    memset(&with, 0, sizeof with);
    with.at = at;
    return compare(&with);
}

const command cmd_compare = {
    .line =
        {
            .name = "compare",
            .operands = {"P.qcf"},
            .about =
                "Runs solvers on one problem and adds the samples of others, such as a QPU. "
                "Prints for each its energy, the gap to the best lower bound of all, its feasible "
                "samples, the errors against the truth, and the seconds. A solver that cannot be "
                "used with the pairwise cost is marked. The best labelling known that a file of "
                "reduce carries is the row known.\n",
            OPTIONS(options),
            .examples = "  qstereo compare p.qcf --truth truth.png --truth-scale 8\n"
                        "  qstereo compare p.qcf --samples qpu.qsf --samples hybrid.qsf \\\n"
                        "      --solvers expansion,trws,best --json\n"
                        "  qstereo compare p.qcf --time-limit 5 --maps maps\n",
        },
    .summary = "run solvers on one problem and print how good each one is",
    .run = run_compare,
};
