#include <stdio.h>
#include <stdlib.h>

#include "json.h"
#include "map_errors.h"
#include "messages.h"
#include "numbers.h"
#include "options.h"

enum { SCALE, TRUTH_SCALE, MAX_RMS, MAX_BAD_HALF, MAX_BAD_ONE, JSON };

static const option options[] = {
    [SCALE] = {"scale", 0, false, "S", "8",
               "MAP holds disparity x S; a .pfm holds pixels whatever S is"},
    [TRUTH_SCALE] = {"truth-scale", 0, false, "S", "8", "the same of TRUTH"},
    [MAX_RMS] = {"max-rms", 0, false, "X", NULL, "exit with 1 if the rms error is above X pixels"},
    [MAX_BAD_HALF] = {"max-bad-0.5", 0, false, "P", NULL,
                      "exit with 1 if more than P percent are off by more than 0.5"},
    [MAX_BAD_ONE] = {"max-bad-1.0", 0, false, "P", NULL,
                     "exit with 1 if more than P percent are off by more than 1"},
    [JSON] = JSON_OPTION,
};

static const command_line line = {
    .name = "score",
    .operands = {"MAP", "TRUTH"},
    .about = "Compares a disparity map with the truth, over the pixels that have a value in both: "
             "the root mean square\n"
             "error in pixels (rms), and the percentage of pixels that are off by more than 0.5 "
             "and 1 pixel (bad-0.5,\n"
             "bad-1.0).\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo score disparity.png truth.png --scale 8 --truth-scale 8\n"
                "  qstereo score disparity.pfm truth.png --truth-scale 16 --max-bad-1.0 10\n",
};

/* The options of the most errors allowed stand in the order of the errors. Returns ANSWER_NO where
 * an error is above what is allowed. */
static int check_limits(const char *name, const arguments *given, const double errors[ERRORS],
                        const double most[ERRORS])
{
    int status = DONE;
    for (size_t i = 0; i < ERRORS; i++) {
        if (given->values[MAX_RMS + i] != NULL && errors[i] > most[i]) {
            status = fail(ANSWER_NO, name, "%s is %.6g, above %s", options[MAX_RMS + i].name + 4,
                          errors[i], given->values[MAX_RMS + i]);
        }
    }
    return status;
}

static int score_maps(const arguments *given, const qs_map *map, const qs_map *truth,
                      const double most[ERRORS])
{
    const char *name = input_name(given->operands[0]), *truth_name = input_name(given->operands[1]);
    map_errors errors;
    int status = map_errors_find(name, map, truth_name, truth, &errors);
    if (status != DONE) {
        return status;
    }
    if (given->values[JSON] != NULL) {
        json_begin();
        map_errors_json(&errors);
        json_end();
    } else {
        map_errors_print(&errors);
    }
    if (errors.pixels == 0) {
        return fail(ANSWER_NO, name, "no pixel has a value both here and in %s", truth_name);
    }
    return check_limits(name, given, errors.of, most);
}

static int read_and_score(const arguments *given, uint32_t scale, uint32_t truth_scale,
                          const double most[ERRORS])
{
    qs_map map, truth;
    int32_t *values = NULL, *truth_values = NULL;
    int status = map_read(given->operands[0], scale, &map, &values);
    if (status == DONE) {
        status = map_read(given->operands[1], truth_scale, &truth, &truth_values);
    }
    if (status == DONE) {
        status = score_maps(given, &map, &truth, most);
    }
    free(values);
    free(truth_values);
    return status;
}

int cmd_score(int argc, char **argv)
{
    arguments given;
    uint32_t scale, truth_scale;
    double most[ERRORS] = {0, 0, 0};
    char spelled[32];
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    status = number_read("--scale", given.values[SCALE], 1, 65536, &scale);
    if (status == DONE) {
        status = truth_scale_read(given.values[TRUTH_SCALE], &truth_scale);
    }
    for (size_t i = 0; i < ERRORS && status == DONE; i++) {
        (void)snprintf(spelled, sizeof spelled, "--%s", options[MAX_RMS + i].name);
        if (given.values[MAX_RMS + i] != NULL) {
            status = threshold_read(spelled, given.values[MAX_RMS + i], &most[i]);
        }
    }
    return status == DONE ? read_and_score(&given, scale, truth_scale, most) : status;
}
