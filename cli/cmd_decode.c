#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "decimal.h"
#include "disparity_map.h"
#include "json.h"
#include "messages.h"
#include "numbers.h"
#include "options.h"
#include "output.h"
#include "survey.h"

enum { OUTPUT, REPAIR, SAMPLE, SCALE, COLOR, JSON, MEMORY_LIMIT };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "MAP", NULL, "the map to write: .png, .pgm or .pfm; - is standard output, PGM"},
    [REPAIR] = {"repair", 0, false, NULL, NULL, "make samples feasible first, each with the labels that cost least"},
    [SAMPLE] = {"sample", 0, false, "N", NULL, "take this sample, counted from 0 (default the best feasible one)"},
    [SCALE] = {"scale", 0, false, "S", "8", "a .png or .pgm holds disparity x S, from 2; a .pfm holds pixels"},
    [COLOR] = {"color", 0, false, NULL, NULL, "write a map in colours beside it, MAP.color.png (or .ppm)"},
    [JSON] = {"json", 0, false, NULL, NULL, "print one JSON object"},
    [MEMORY_LIMIT] = {"memory-limit", 0, false, "MIB", "4096", "most memory for files and work on them"},
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
    const char *output;
    char *colour; /* the second map; NULL = none. To be freed */
    map_format format;
    uint32_t scale, sample;
    bool one_sample, repair, json;
} request;

/* The sample that becomes the map. */
typedef struct chosen {
    uint32_t sample;
    int64_t energy;
    uint32_t repaired; /* sites */
    uint8_t *bits;     /* to be freed */
} chosen;

static int name_colour(request *asked)
{
    if (output_is_straight(asked->output)) {
        return fail_usage("--color needs the name of a file to put its map beside");
    }
    const char *slash = strrchr(asked->output, '/');
    const char *dot = strrchr(slash != NULL ? slash : asked->output, '.');
    int stem = (int)(dot - asked->output);
    bool png = asked->format != MAP_PGM && picture_library_writes_png();
    size_t size = strlen(asked->output) + sizeof ".color.png";
    asked->colour = malloc(size);
    if (asked->colour == NULL) {
        return fail_memory(asked->output);
    }
    (void)snprintf(asked->colour, size, "%.*s.color.%s", stem, asked->output, png ? "png" : "ppm");
    return DONE;
}

static int read_request(const arguments *given, request *asked)
{
    const char *const *values = given->values;
    memset(asked, 0, sizeof *asked);
    asked->output = values[OUTPUT];
    asked->repair = values[REPAIR] != NULL;
    asked->json = values[JSON] != NULL;
    asked->one_sample = values[SAMPLE] != NULL;
    int status = map_format_of(asked->output, output_is_straight(asked->output), &asked->format);
    if (status == DONE) {
        status = number_read("--scale", values[SCALE], 2, 65535, &asked->scale);
    }
    if (status == DONE && asked->one_sample) {
        status = number_read("--sample", values[SAMPLE], 0, UINT32_MAX, &asked->sample);
    }
    if (status == DONE && asked->json && output_is_standard(asked->output)) {
        status = fail_usage("--json and the map cannot both go to standard output");
    }
    if (status == DONE && values[COLOR] != NULL) {
        status = name_colour(asked);
    }
    return status;
}

/* Whether the problem is one that a map can be made of. */
static int check_grid(const problem_file *problem)
{
    const qs_labels *labels = &problem->qubo.labels;
    if (!problem->qubo.has_labels || labels->width == 0) {
        return fail(BAD_INPUT, problem->name, "is no problem on a grid of pixels, so there is no map to be made of it");
    }
    if (labels->frame.first > INT32_MAX) {
        return fail(BAD_INPUT, problem->name, "its disparities begin at %" PRIu32 ", more than can be held",
                    labels->frame.first);
    }
    return DONE;
}

static size_t bits_size(const answer *both)
{
    return ((size_t)both->samples.view.variables + 7) / 8;
}

/* Repairs a copy of one sample in `to->bits`. */
static void repair_sample(const answer *both, uint32_t sample, chosen *to)
{
    memcpy(to->bits, qs_samples_bits(&both->samples.view, sample), bits_size(both));
    to->sample = sample;
    to->repaired = qs_sample_repair(&both->problem.index, to->bits);
    to->energy = qs_qubo_energy(&both->problem.index, to->bits);
}

static void choose_repaired(const answer *both, const request *asked, chosen *taken)
{
    uint32_t first = asked->one_sample ? asked->sample : 0;
    uint32_t end = asked->one_sample ? asked->sample + 1 : both->samples.view.count;
    chosen best;
    repair_sample(both, first, taken);
    best = *taken;
    for (uint32_t sample = first + 1; sample < end; sample++) {
        repair_sample(both, sample, taken);
        if (taken->energy < best.energy) {
            best = *taken;
        }
    }
    /* Again, for its bits: the buffer holds one sample. */
    repair_sample(both, best.sample, taken);
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
    choose_repaired(both, asked, taken);
    return DONE;
}

/* Puts the label of each site where the site is in the picture. */
static void place_sites(const qs_labels *labels, const uint16_t *labelling, uint32_t *disparities)
{
    const qs_frame *frame = &labels->frame;
    size_t site = 0;
    for (size_t cell = 0; cell < (size_t)labels->width * labels->height; cell++) {
        size_t x = frame->x + cell % labels->width, y = frame->y + cell / labels->width;
        if (labels->mask == NULL || (labels->mask[cell / 8] >> cell % 8 & 1) != 0) {
            disparities[y * frame->picture_width + x] = frame->first + labelling[site++];
        }
    }
}

static int make_map(const answer *both, const chosen *taken, budget *limit, uint32_t **disparities)
{
    const problem_file *problem = &both->problem;
    const qs_frame *frame = &problem->qubo.labels.frame;
    void *labelling = NULL, *pixels = NULL;
    if (frame->picture_height > SIZE_MAX / sizeof **disparities / frame->picture_width) {
        return budget_fail(limit, problem->name);
    }
    size_t count = (size_t)frame->picture_width * frame->picture_height;
    int status = budget_allocate(limit, problem->name, count * sizeof **disparities, &pixels);
    *disparities = pixels;
    if (status == DONE) {
        status = budget_allocate(limit, problem->name, problem->qubo.groups * sizeof(uint16_t), &labelling);
    }
    if (status != DONE) {
        return status;
    }
    for (size_t i = 0; i < count; i++) {
        (*disparities)[i] = MAP_NO_VALUE;
    }
    qs_status decoded = qs_sample_decode(&problem->index, taken->bits, labelling);
    if (decoded == QS_OK) {
        place_sites(&problem->qubo.labels, labelling, *disparities);
    } else {
        status = fail_status(both->samples.name, decoded);
    }
    free(labelling);
    return status;
}

static void print_result(const answer *both, const request *asked, const chosen *taken)
{
    char energy[DECIMAL_SIZE];
    if (asked->json) {
        json_begin();
        json_count("sample", taken->sample);
        json_units("energy", taken->energy, both->problem.scale);
        json_count("repaired", taken->repaired);
        json_name("map", asked->output);
        json_name("color_map", asked->colour);
        json_end();
        return;
    }
    decimal_write(taken->energy, both->problem.scale, energy);
    printf("%s%s%s: sample %" PRIu32 " of %" PRIu32 ", energy %s, %" PRIu32 " sites repaired\n", asked->output,
           asked->colour != NULL ? ", " : "", asked->colour != NULL ? asked->colour : "", taken->sample,
           both->samples.view.count, energy, taken->repaired);
}

/* Writes the files, the result and then makes the files appear. */
static int write_files(const answer *both, const request *asked, const chosen *taken, const file_bytes files[2])
{
    const char *const paths[2] = {asked->output, asked->colour};
    size_t count = asked->colour != NULL ? 2 : 1, opened = 0;
    output outs[2];
    int status = DONE;
    while (status == DONE && opened < count) {
        status = output_open(&outs[opened], paths[opened]);
        opened += status == DONE;
    }
    if (status != DONE) {
        while (opened > 0) {
            output_abandon(&outs[--opened]);
        }
        return status;
    }
    for (size_t i = 0; i < count; i++) {
        (void)output_write(&outs[i], files[i].bytes, files[i].size); /* a refusal is reported by the commit */
    }
    if (!output_is_standard(asked->output)) {
        print_result(both, asked, taken);
    }
    return output_commit(outs, count);
}

static int write_map(const answer *both, const request *asked, const chosen *taken, const uint32_t *disparities)
{
    const qs_labels *labels = &both->problem.qubo.labels;
    const pixel_map map = {disparities, labels->frame.picture_width, labels->frame.picture_height, labels->frame.first,
                           labels->frame.first + labels->labels - 1};
    file_bytes files[2] = {{NULL, 0}, {NULL, 0}};
    int status = map_encode(&map, asked->format, asked->scale, asked->output, &files[0]);
    if (status == DONE && asked->colour != NULL) {
        status =
            map_encode_colour(&map, asked->format != MAP_PGM && picture_library_writes_png(), asked->colour, &files[1]);
    }
    if (status == DONE) {
        status = write_files(both, asked, taken, files);
    }
    file_free(&files[0]);
    file_free(&files[1]);
    return status;
}

static int decode(const answer *both, const request *asked, budget *limit)
{
    chosen taken = {0, 0, 0, NULL};
    uint32_t *disparities = NULL;
    int status = check_grid(&both->problem);
    if (status == DONE) {
        status = choose(both, asked, limit, &taken);
    }
    if (status == DONE) {
        status = make_map(both, &taken, limit, &disparities);
    }
    if (status == DONE) {
        status = write_map(both, asked, &taken, disparities);
    }
    free(disparities);
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
    free(asked.colour);
    return status;
}
