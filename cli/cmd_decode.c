#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decimal.h"
#include "json.h"
#include "map_output.h"
#include "messages.h"
#include "numbers.h"
#include "options.h"
#include "survey.h"

enum { OUTPUT, REPAIR, SAMPLE, SCALE, COLOR, JSON, MEMORY_LIMIT };

static const option options[] = {
    [OUTPUT] = MAP_OUTPUT_OPTION,
    [REPAIR] = {"repair", 0, false, NULL, NULL,
                "make samples feasible first, each with the labels that cost least"},
    [SAMPLE] = {"sample", 0, false, "N", NULL,
                "take this sample, counted from 0 (default the best feasible one)"},
    [SCALE] = SCALE_OPTION,
    [COLOR] = COLOR_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "decode",
    .operands = {"P.qcf", "S.qsf"},
    .optional = 1,
    .about = "Turns a sample into a disparity map of the size of the left picture. 0 means no "
             "value (infinity in a .pfm);\n"
             "a disparity of 0 is held as 1. 8 bits where all values fit, else 16. Exits with 1 if "
             "no sample is feasible.\n"
             "A problem that was reduced gives the whole map too; where nothing was left to solve, "
             "S.qsf need not be given.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo decode p.qcf s.qsf -o disparity.png --scale 8 --color\n"
                "  qstereo decode p.qcf s.qsf -o disparity.pfm --repair\n"
                "  qstereo decode proven.qcf -o disparity.png\n",
};

/* What the command line asks for. */
typedef struct request {
    map_request map;
    uint32_t sample;
    bool one_sample, repair, json;
} request;

/* The sample that becomes the map. */
typedef struct chosen {
    bool none; /* there are no samples, as there are no variables */
    uint32_t sample;
    int64_t energy; /* F */
    uint32_t repaired; /* sites */
    uint8_t *bits;
    uint16_t *labelling; /* of all sites */
    void *workspace; /* of the repair */
    size_t workspace_size;
} chosen;

static int read_request(const arguments *given, request *asked)
{
    const char *const *values = given->values;
    asked->repair = values[REPAIR] != NULL;
    asked->json = values[JSON] != NULL;
    asked->one_sample = values[SAMPLE] != NULL;
    int status = map_request_read(values[OUTPUT], values[SCALE], values[COLOR] != NULL, asked->json,
                                  &asked->map);
    if (status == DONE && asked->one_sample) {
        status = number_read("--sample", values[SAMPLE], 0, UINT32_MAX, &asked->sample);
    }
    return status;
}

/* Room for a sample, its labelling and its repair; free_chosen frees it in any case. */
static int allocate_chosen(const problem_file *problem, bool repair, budget *limit, chosen *made)
{
    const qs_qubo *qubo = &problem->qubo;
    void *bits = NULL, *labelling = NULL;
    memset(made, 0, sizeof *made);
    int status = budget_allocate(limit, problem->name, ((size_t)qubo->variables + 7) / 8, &bits);
    made->bits = bits;
    if (status == DONE) {
        status = budget_allocate(limit, problem->name, sizeof *made->labelling * qubo->labels.sites,
                                 &labelling);
    }
    made->labelling = labelling;
    if (status == DONE && repair) {
        made->workspace_size = qs_repair_workspace(&problem->index);
        status = budget_allocate(limit, problem->name, made->workspace_size, &made->workspace);
    }
    return status;
}

static void free_chosen(chosen *freed)
{
    free(freed->bits);
    free(freed->labelling);
    free(freed->workspace);
}

static qs_status take_sample(const answer *both, uint32_t sample, bool repair, chosen *to)
{
    const qs_index *index = &both->problem.index;
    memcpy(to->bits, qs_samples_bits(&both->samples.view, sample),
           ((size_t)both->samples.view.variables + 7) / 8);
    to->sample = sample;
    if (repair) {
        qs_status status =
            qs_sample_repair(index, to->bits, to->workspace, to->workspace_size, &to->repaired);
        if (status != QS_OK) {
            return status;
        }
    }
    return sample_labels(index, to->bits, to->labelling, &to->energy);
}

static int choose_repaired(const answer *both, const request *asked, chosen *taken)
{
    uint32_t first = asked->one_sample ? asked->sample : 0;
    uint32_t end = asked->one_sample ? asked->sample + 1 : both->samples.view.count;
    uint32_t best = first;
    int64_t best_energy = INT64_MAX;
    qs_status status = QS_OK;
    for (uint32_t sample = first; sample < end && status == QS_OK; sample++) {
        status = take_sample(both, sample, true, taken);
        if (status == QS_OK && taken->energy < best_energy) {
            best = sample;
            best_energy = taken->energy;
        }
    }
    /* Again, for its bits: there is room for one sample. */
    if (status == QS_OK) {
        status = take_sample(both, best, true, taken);
    }
    return status == QS_OK ? DONE : fail_status(both->samples.name, status);
}

static int choose_feasible(const answer *both, const request *asked, const survey *seen,
                           chosen *taken)
{
    const char *name = both->samples.name;
    if (!asked->one_sample && seen->feasible == 0) {
        return fail(ANSWER_NO, name,
                    "none of the %" PRIu32 " samples is feasible: --repair makes them so",
                    both->samples.view.count);
    }
    qs_status status =
        take_sample(both, asked->one_sample ? asked->sample : seen->best, false, taken);
    if (status == QS_E_INFEASIBLE) {
        return fail(ANSWER_NO, name,
                    "sample %" PRIu32 " is not feasible (at %" PRIu32
                    " places; %s where it is): --repair makes it so",
                    taken->sample, qs_sample_infeasible(&both->problem.index, taken->bits),
                    feasible_means(&both->problem.qubo));
    }
    return status == QS_OK ? DONE : fail_status(name, status);
}

static int choose(const answer *both, const request *asked, budget limit, chosen *taken)
{
    const char *name = both->samples.name;
    uint32_t count = both->samples.view.count;
    survey seen;
    int status = survey_samples(both, limit, &seen);
    if (status == DONE) {
        status = survey_fail_wrong(both, &seen);
    }
    if (status != DONE) {
        return status;
    }
    if (count == 0) {
        return fail(ANSWER_NO, name, "holds no sample");
    }
    if (asked->one_sample && asked->sample >= count) {
        return fail_usage("--sample %" PRIu32 ": %s holds samples 0 to %" PRIu32, asked->sample,
                          name, count - 1);
    }
    return asked->repair ? choose_repaired(both, asked, taken)
                         : choose_feasible(both, asked, &seen, taken);
}

/* All sites are fixed, so the sample of no bits is the only one. */
static int choose_decided(const problem_file *problem, chosen *taken)
{
    taken->none = true;
    qs_status status =
        sample_labels(&problem->index, taken->bits, taken->labelling, &taken->energy);
    return status == QS_OK ? DONE : fail_status(problem->name, status);
}

static void print_result(const answer *both, const request *asked, const chosen *taken)
{
    char energy[DECIMAL_SIZE];
    if (asked->json) {
        json_begin();
        if (taken->none) {
            json_null("sample");
        } else {
            json_count("sample", taken->sample);
        }
        json_units("energy", taken->energy, both->problem.scale);
        json_count("repaired", taken->repaired);
        map_request_json(&asked->map);
        json_end();
        return;
    }
    decimal_write(taken->energy, both->problem.scale, energy);
    map_request_print(&asked->map);
    if (taken->none) {
        printf("nothing was left to solve, energy %s\n", energy);
        return;
    }
    printf("sample %" PRIu32 " of %" PRIu32 ", energy %s, %" PRIu32 " site%s repaired\n",
           taken->sample, both->samples.view.count, energy, taken->repaired,
           plural(taken->repaired));
}

/* Writes the files, prints the result and then makes the files appear. */
static int write_files(const answer *both, const request *asked, const chosen *taken,
                       const pixel_map *map)
{
    map_outputs outs;
    int status = map_outputs_open(&asked->map, &outs);
    if (status != DONE) {
        return status;
    }
    status = map_outputs_write(&asked->map, map, &outs);
    if (status != DONE) {
        map_outputs_abandon(&outs);
        return status;
    }
    if (!output_is_standard(asked->map.output)) {
        print_result(both, asked, taken);
    }
    return map_outputs_commit(&outs);
}

static int decode(const answer *both, const request *asked, budget *limit)
{
    const problem_file *problem = &both->problem;
    bool sampled = both->samples.name != NULL;
    chosen taken = {.none = false};
    uint32_t *disparities = NULL;
    pixel_map map;
    int status = map_check_grid(problem);
    if (status == DONE) {
        status = allocate_chosen(problem, asked->repair, limit, &taken);
    }
    if (status == DONE) {
        status = sampled ? choose(both, asked, *limit, &taken) : choose_decided(problem, &taken);
    }
    if (status == DONE) {
        status = map_of_labelling(problem, taken.labelling, limit, &disparities, &map);
    }
    if (status == DONE) {
        status = write_files(both, asked, &taken, &map);
    }
    free(disparities);
    free_chosen(&taken);
    return status;
}

/* Without samples, where nothing is left for them to say. */
static int open_decided(const char *path, const request *asked, budget *limit, answer *opened)
{
    memset(opened, 0, sizeof *opened);
    int status = problem_open(path, limit, &opened->problem);
    if (status == DONE && opened->problem.qubo.variables > 0) {
        status = fail_usage("the operand S.qsf is missing: samples that say the %" PRIu32
                            " variables of %s",
                            opened->problem.qubo.variables, opened->problem.name);
    } else if (status == DONE && asked->one_sample) {
        status = fail_usage("--sample goes with S.qsf");
    }
    if (status == DONE) {
        status = problem_index(&opened->problem, limit);
    }
    if (status != DONE) {
        answer_close(opened);
    }
    return status;
}

int cmd_decode(int argc, char **argv)
{
    arguments given;
    request asked;
    budget limit;
    answer both;
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    status = budget_read(given.values[MEMORY_LIMIT], &limit);
    if (status != DONE) {
        return status;
    }
    status = read_request(&given, &asked);
    if (status == DONE) {
        status = given.operands[1] != NULL
                     ? answer_open(given.operands[0], given.operands[1], &limit, &both)
                     : open_decided(given.operands[0], &asked, &limit, &both);
    }
    if (status == DONE) {
        status = decode(&both, &asked, &limit);
        answer_close(&both);
    }
    map_request_free(&asked.map);
    return status;
}
