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
    [REPAIR] = {"repair", 0, false, NULL, NULL, "make samples feasible first, each with the labels that cost least"},
    [SAMPLE] = {"sample", 0, false, "N", NULL, "take this sample, counted from 0 (default the best feasible one)"},
    [SCALE] = SCALE_OPTION,
    [COLOR] = COLOR_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "decode",
    .operands = {"P.qcf", "S.qsf"},
    .about =
        "Turns a sample into a disparity map of the size of the left picture. 0 means no value (infinity in a .pfm);\n"
        "a disparity of 0 is held as 1. 8 bits where all values fit, else 16. Exits with 1 if no sample is feasible.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo decode p.qcf s.qsf -o disparity.png --scale 8 --color\n"
                "  qstereo decode p.qcf s.qsf -o disparity.pfm --repair\n",
};

/* What the command line asks for. */
typedef struct request {
    map_request map;
    uint32_t sample;
    bool one_sample, repair, json;
} request;

/* The sample that becomes the map. */
typedef struct chosen {
    uint32_t sample;
    int64_t energy;
    uint32_t repaired; /* sites */
    uint8_t *bits;     /* to be freed */
    void *workspace;   /* of the repair; to be freed */
} chosen;

static int read_request(const arguments *given, request *asked)
{
    const char *const *values = given->values;
    asked->repair = values[REPAIR] != NULL;
    asked->json = values[JSON] != NULL;
    asked->one_sample = values[SAMPLE] != NULL;
    int status = map_request_read(values[OUTPUT], values[SCALE], values[COLOR] != NULL, asked->json, &asked->map);
    if (status == DONE && asked->one_sample) {
        status = number_read("--sample", values[SAMPLE], 0, UINT32_MAX, &asked->sample);
    }
    return status;
}

static size_t bits_size(const answer *both)
{
    return ((size_t)both->samples.view.variables + 7) / 8;
}

/* Repairs a copy of one sample in `to->bits`. */
static int repair_sample(const answer *both, uint32_t sample, chosen *to)
{
    const qs_index *index = &both->problem.index;
    memcpy(to->bits, qs_samples_bits(&both->samples.view, sample), bits_size(both));
    to->sample = sample;
    qs_status repaired = qs_sample_repair(index, to->bits, to->workspace, qs_repair_workspace(index), &to->repaired);
    to->energy = qs_qubo_energy(index, to->bits);
    return repaired == QS_OK ? DONE : fail_status(both->samples.name, repaired);
}

static int choose_repaired(const answer *both, const request *asked, budget *limit, chosen *taken)
{
    uint32_t first = asked->one_sample ? asked->sample : 0;
    uint32_t end = asked->one_sample ? asked->sample + 1 : both->samples.view.count;
    int status = budget_allocate(limit, both->problem.name, qs_repair_workspace(&both->problem.index), &taken->workspace);
    if (status == DONE) {
        status = repair_sample(both, first, taken);
    }
    chosen best = *taken;
    for (uint32_t sample = first + 1; status == DONE && sample < end; sample++) {
        status = repair_sample(both, sample, taken);
        if (taken->energy < best.energy) {
            best = *taken;
        }
    }
    /* Again, for its bits: the buffer holds one sample. */
    return status == DONE ? repair_sample(both, best.sample, taken) : status;
}

static int choose_feasible(const answer *both, const request *asked, const survey *seen, chosen *taken)
{
    const qs_index *index = &both->problem.index;
    const char *name = both->samples.name;
    taken->sample = asked->one_sample ? asked->sample : seen->best;
    if (!asked->one_sample && seen->feasible == 0) {
        return fail(ANSWER_NO, name, "none of the %" PRIu32 " samples is feasible: --repair makes them so",
                    both->samples.view.count);
    }
    memcpy(taken->bits, qs_samples_bits(&both->samples.view, taken->sample), bits_size(both));
    taken->energy = qs_qubo_energy(index, taken->bits);
    uint32_t broken = qs_sample_infeasible(index, taken->bits);
    if (broken > 0) {
        return fail(ANSWER_NO, name,
                    "sample %" PRIu32 " is not feasible (%" PRIu32 " sites have not exactly one label): "
                    "--repair makes it so",
                    taken->sample, broken);
    }
    return DONE;
}

static int choose(const answer *both, const request *asked, budget *limit, chosen *taken)
{
    const char *name = both->samples.name;
    uint32_t count = both->samples.view.count;
    void *bits = NULL;
    survey seen = survey_samples(both);
    int status = survey_fail_wrong(both, &seen);
    if (status != DONE) {
        return status;
    }
    if (count == 0) {
        return fail(ANSWER_NO, name, "holds no sample");
    }
    if (asked->one_sample && asked->sample >= count) {
        return fail_usage("--sample %" PRIu32 ": %s holds samples 0 to %" PRIu32, asked->sample, name, count - 1);
    }
    status = budget_allocate(limit, name, bits_size(both), &bits);
    if (status != DONE) {
        return status;
    }
    taken->bits = bits;
    if (!asked->repair) {
        return choose_feasible(both, asked, &seen, taken);
    }
    return choose_repaired(both, asked, limit, taken);
}

static int label_sites(const answer *both, const chosen *taken, budget *limit, uint16_t **labelling)
{
    void *labels = NULL;
    int status = budget_allocate(limit, both->problem.name, both->problem.qubo.labels.sites * sizeof **labelling, &labels);
    *labelling = labels;
    if (status != DONE) {
        return status;
    }
    qs_status decoded = qs_sample_decode(&both->problem.index, taken->bits, *labelling);
    return decoded == QS_OK ? DONE : fail_status(both->samples.name, decoded);
}

static void print_result(const answer *both, const request *asked, const chosen *taken)
{
    char energy[DECIMAL_SIZE];
    if (asked->json) {
        json_begin();
        json_count("sample", taken->sample);
        json_units("energy", taken->energy, both->problem.scale);
        json_count("repaired", taken->repaired);
        map_request_json(&asked->map);
        json_end();
        return;
    }
    decimal_write(taken->energy, both->problem.scale, energy);
    map_request_print(&asked->map);
    printf("sample %" PRIu32 " of %" PRIu32 ", energy %s, %" PRIu32 " sites repaired\n", taken->sample,
           both->samples.view.count, energy, taken->repaired);
}

/* Writes the files, prints the result and then makes the files appear. */
static int write_files(const answer *both, const request *asked, const chosen *taken, const pixel_map *map)
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
    chosen taken = {0, 0, 0, NULL, NULL};
    uint16_t *labelling = NULL;
    uint32_t *disparities = NULL;
    pixel_map map;
    int status = map_check_grid(&both->problem);
    if (status == DONE) {
        status = choose(both, asked, limit, &taken);
    }
    if (status == DONE) {
        status = label_sites(both, &taken, limit, &labelling);
    }
    if (status == DONE) {
        status = map_of_labelling(&both->problem, labelling, limit, &disparities, &map);
    }
    if (status == DONE) {
        status = write_files(both, asked, &taken, &map);
    }
    free(disparities);
    free(labelling);
    free(taken.workspace);
    free(taken.bits);
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
        status = answer_open(given.operands[0], given.operands[1], &limit, &both);
    }
    if (status == DONE) {
        status = decode(&both, &asked, &limit);
        answer_close(&both);
    }
    map_request_free(&asked.map);
    return status;
}
