#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "makers/kept_list.h"
#include "meaning_output.h"
#include "pictures/disparity_map.h"
#include "pictures/picture_write.h"
#include "survey.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"
#include "text/plain.h"

enum { OUTPUT, REPAIR, SAMPLE, SCALE, COLOR, PALETTE, SCALE_BAR, BOXES, JSON, MEMORY_LIMIT };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "OUT", NULL, "file to write, see above; - is standard output"},
    [REPAIR] = {"repair", 0, false, NULL, NULL,
                "make samples feasible first, with the labels that cost least"},
    [SAMPLE] = {"sample", 0, false, "N", NULL,
                "sample to take, counted from 0 (default the best feasible one)"},
    [SCALE] = SCALE_OPTION,
    [COLOR] = COLOR_OPTION,
    [PALETTE] = PALETTE_OPTION,
    [SCALE_BAR] = SCALE_BAR_OPTION,
    [BOXES] =
        {"boxes", 0, false, "BOXES.csv", NULL,
         "of a problem of detect: the boxes that it was made of, to write those that are kept"},
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct request {
    map_request map; /* of disparities, see is_map */
    meaning_output other; /* of all else */
    box_file boxes;
    output *file; /* of that */
    bool one_sample, repair;
    uint32_t sample; /* if only one sample is asked for */
} request;

/* A sample that may become the map. */
typedef struct chosen {
    bool none; /* there are no samples, because there are no variables */
    uint32_t sample;
    int64_t energy; /* F */
    uint32_t repaired; /* sites */
    uint8_t *bits;
    uint16_t *labelling; /* of all sites */
} chosen;

/* What repairs samples. */
typedef struct workspace {
    void *memory;
    size_t size;
} workspace;

static int read_request(job *at, request *asked)
{
    const char *const *values = at->values;
    memset(asked, 0, sizeof *asked);
    asked->repair = values[REPAIR] != NULL;
    asked->one_sample = values[SAMPLE] != NULL;
    return asked->one_sample
               ? number_read("--sample", values[SAMPLE], 0, UINT32_MAX, &asked->sample)
               : DONE;
}

/* Room for a sample and its labelling. */
static int take_room(job *at, chosen *made)
{
    const problem_file *problem = &at->both.problem;
    memset(made, 0, sizeof *made);
    made->bits = budget_take(&at->limit, problem->name, ((size_t)problem->qubo.variables + 7) / 8);
    if (made->bits == NULL) {
        return NO_RESOURCE;
    }
    made->labelling = budget_take(&at->limit, problem->name,
                                  sizeof *made->labelling * problem->qubo.labels.sites);
    return made->labelling != NULL ? DONE : NO_RESOURCE;
}

/* Copies a sample, repairs it if there is a workspace for that, and reads its labelling. */
static qs_status take_sample(const answer *both, uint32_t sample, const workspace *repair,
                             chosen *to)
{
    const qs_index *index = &both->problem.index;
    memcpy(to->bits, qs_samples_bits(&both->samples.view, sample),
           ((size_t)both->samples.view.variables + 7) / 8);
    to->sample = sample;
    if (repair != NULL) {
        qs_status status =
            qs_sample_repair(index, to->bits, repair->memory, repair->size, &to->repaired);
        if (status != QS_OK) {
            return status;
        }
    }
    return sample_labels(index, to->bits, to->labelling, &to->energy);
}

/* Repairs the samples that are asked for and takes the best one, the first of equals. */
static int choose_repaired(job *at, const request *asked, chosen *taken)
{
    const answer *both = &at->both;
    uint32_t first = asked->one_sample ? asked->sample : 0;
    uint32_t end = asked->one_sample ? asked->sample + 1 : both->samples.view.count;
    chosen next;
    workspace repair = {NULL, qs_repair_workspace(&both->problem.index)};
    repair.memory = budget_take(&at->limit, both->problem.name, repair.size);
    if (repair.memory == NULL) {
        return NO_RESOURCE;
    }
    TRY(take_room(at, &next));
    for (uint32_t sample = first; sample < end; sample++) {
        qs_status status = take_sample(both, sample, &repair, &next);
        if (status != QS_OK) {
            return fail_status(both->samples.name, status);
        }
        if (sample == first || next.energy < taken->energy) {
            chosen better = next;
            next = *taken;
            *taken = better;
        }
    }
    return DONE;
}

static int choose_feasible(const answer *both, const request *asked, const survey *seen,
                           chosen *taken)
{
    const char *name = both->samples.name;
    if (!asked->one_sample && seen->feasible == 0) {
        return fail(ANSWER_NO, name,
                    "none of the %" PRIu32 " samples is feasible: add --repair to make them so",
                    both->samples.view.count);
    }
    qs_status status =
        take_sample(both, asked->one_sample ? asked->sample : seen->best, NULL, taken);
    if (status == QS_E_INFEASIBLE) {
        return fail(ANSWER_NO, name,
                    "sample %" PRIu32 " is not feasible (%" PRIu32
                    " places are wrong; a sample is feasible if %s): add --repair to make it so",
                    taken->sample, qs_sample_infeasible(&both->problem.index, taken->bits),
                    feasible_means(&both->problem.qubo));
    }
    return status == QS_OK ? DONE : fail_status(name, status);
}

static int choose(job *at, const request *asked, chosen *taken)
{
    const answer *both = &at->both;
    const char *name = both->samples.name;
    uint32_t count = both->samples.view.count;
    survey seen;
    TRY(survey_samples(both, &at->limit, &seen));
    TRY(survey_fail_wrong(both, &seen));
    if (count == 0) {
        return fail(ANSWER_NO, name, "holds no sample");
    }
    if (asked->one_sample && asked->sample >= count) {
        return fail_usage("--sample %" PRIu32 ": %s holds samples 0 to %" PRIu32, asked->sample,
                          name, count - 1);
    }
    return asked->repair ? choose_repaired(at, asked, taken)
                         : choose_feasible(both, asked, &seen, taken);
}

/* All sites are fixed, so the sample without bits is the only one. */
static int choose_decided(const problem_file *problem, chosen *taken)
{
    taken->none = true;
    qs_status status =
        sample_labels(&problem->index, taken->bits, taken->labelling, &taken->energy);
    return status == QS_OK ? DONE : fail_status(problem->name, status);
}

/* Whether a map of disparities is asked for. */
static bool is_map(const job *at)
{
    return at->both.problem.qubo.labels.meaning.kind == QS_MEANS_DISPARITY &&
           !path_ends(at->values[OUTPUT], ".npy");
}

/* Only maps have a scale and colours. */
static int check_options(const job *at)
{
    for (size_t i = 0; i < at->given->given_count; i++) {
        size_t index = at->given->given[i].index;
        if (index == SCALE || index == COLOR || index == PALETTE || index == SCALE_BAR) {
            return fail_usage("--%s goes with maps of disparities, which %s cannot be",
                              options[index].name, at->values[OUTPUT]);
        }
    }
    return DONE;
}

static int read_boxes(job *at, request *asked)
{
    const problem_file *problem = &at->both.problem;
    const char *path = at->values[BOXES];
    if (path == NULL) {
        return DONE;
    }
    TRY(boxes_read(path, false, &at->limit, &asked->boxes));
    asked->other.boxes = &asked->boxes;
    return kept_boxes_check(problem->name, problem->qubo.labels.sites, &asked->boxes);
}

/* Reads what kind of output is asked for; the problem is open. */
static int read_output(job *at, request *asked)
{
    const problem_file *problem = &at->both.problem;
    const qs_labels *labels = &problem->qubo.labels;
    const char *path = at->values[OUTPUT];
    TRY(meaning_ending_check(problem->name, labels, path));
    if (at->values[BOXES] != NULL &&
        (labels->meaning.kind != QS_MEANS_KEEP || path_ends(path, ".npy"))) {
        return fail_usage("--boxes goes with a problem of detect and a list, .csv, not with %s",
                          path);
    }
    if (is_map(at)) {
        const char *const *values = at->values;
        const map_options given = {path, values[SCALE], values[COLOR], values[PALETTE],
                                   values[SCALE_BAR]};
        TRY(map_request_read(&given, &at->limit, &asked->map));
        return map_check(problem->name, labels, asked->map.format);
    }
    TRY(check_options(at));
    TRY(meaning_output_read(problem->name, labels, path, &asked->other));
    return read_boxes(at, asked);
}

static int write_output(job *at, request *asked, const uint16_t *labelling)
{
    const problem_file *problem = &at->both.problem;
    const qs_labels *labels = &problem->qubo.labels;
    pixel_map map;
    if (is_map(at)) {
        TRY(map_of_labelling(problem->name, labels, labelling, &at->limit, &map));
        TRY(map_request_open(&asked->map, at));
        return map_request_write(&asked->map, &map);
    }
    TRY(job_open_output(at, at->values[OUTPUT], &asked->file));
    return meaning_output_write(problem->name, labels, labelling, &asked->other, &at->limit,
                                asked->file);
}

static void print_result(const job *at, const request *asked, const chosen *taken)
{
    const answer *both = &at->both;
    char energy[DECIMAL_SIZE];
    if (at->json) {
        json_begin();
        if (taken->none) {
            json_null("sample");
        } else {
            json_count("sample", taken->sample);
        }
        json_units("energy", taken->energy, both->problem.scale);
        json_count("repaired", taken->repaired);
        if (is_map(at)) {
            map_request_json(&asked->map);
        } else {
            json_name("output", at->values[OUTPUT]);
        }
        json_end();
        return;
    }
    decimal_write(taken->energy, both->problem.scale, energy);
    job_print_outputs(at, at->values[OUTPUT]);
    if (taken->none) {
        printf("every site was decided, energy %s\n", energy);
        return;
    }
    printf("sample %" PRIu32 " of %" PRIu32 ", energy %s, %" PRIu32 " site%s repaired\n",
           taken->sample, both->samples.view.count, energy, taken->repaired,
           plural(taken->repaired));
}

/* Checks that samples are not needed: all sites are decided. */
static int check_decided(const problem_file *problem, const request *asked)
{
    if (problem->qubo.variables > 0) {
        return fail_usage("the operand S.qsf is missing: samples of the %" PRIu32
                          " variables of %s",
                          problem->qubo.variables, problem->name);
    }
    return asked->one_sample ? fail_usage("--sample goes with S.qsf: leave it out") : DONE;
}

static int open_files(job *at, request *asked, bool sampled)
{
    problem_file *problem = &at->both.problem;
    TRY(job_open_problem(at));
    TRY(sampled ? job_open_samples(at) : check_decided(problem, asked));
    TRY(problem_index(problem, &at->limit));
    if (!problem->qubo.has_labels) {
        return fail(BAD_INPUT, problem->name,
                    "does not say which labels its variables stand for (chunk labl), so no map "
                    "can be made from it");
    }
    return read_output(at, asked);
}

static int run_decode(job *at)
{
    const problem_file *problem = &at->both.problem;
    bool sampled = at->given->operands[1] != NULL;
    request asked;
    chosen taken;
    TRY(read_request(at, &asked));
    TRY(open_files(at, &asked, sampled));
    if (is_map(at)) {
        TRY(budget_need(&at->limit, problem->name, map_bytes(&asked.map, &problem->qubo.labels)));
    }
    TRY(take_room(at, &taken));
    TRY(sampled ? choose(at, &asked, &taken) : choose_decided(problem, &taken));
    TRY(write_output(at, &asked, taken.labelling));
    TRY(job_commit(at));
    if (!output_is_standard(is_map(at) ? asked.map.output : at->values[OUTPUT])) {
        print_result(at, &asked, &taken);
    }
    return DONE;
}

const command cmd_decode = {
    .line =
        {
            .name = "decode",
            .operands = {"P.qcf", "S.qsf"},
            .optional = 1,
            .about =
                "Turns a sample into what the labels of its problem stand for. Disparities become "
                "a map of the size of the left picture, .png, .pgm or .pfm: in a .png or .pgm, 0 "
                "means no value, and a disparity of 0 is held as 1; in a .pfm, infinity means no "
                "value; a map has 8 bits if all its values fit, else 16. Greys and classes become "
                "a picture, .png or .pgm; numbers an array, .npy, or a picture; displacements a "
                "field, .flo or KITTI's .png; boxes a list, .csv, of each box from 1 on, and "
                "whether it is kept, or with --boxes the boxes that are kept. An .npy holds the "
                "label of each site as a number from 0 on, "
                "whatever it stands for, and -1 where there is none. Exits with 1 if no sample is "
                "feasible.\n\n"
                "A problem that was reduced gives the whole of it too. If the reduction decided "
                "every site, S.qsf is not needed.\n",
            OPTIONS(options),
            .examples = "  qstereo decode p.qcf s.qsf -o disparity.png --scale 8 --color\n"
                        "  qstereo decode p.qcf s.qsf -o disparity.pfm --repair\n"
                        "  qstereo decode proven.qcf -o disparity.png\n",
        },
    .summary = "turn a sample into a map, picture, field or list",
    .run = run_decode,
};
