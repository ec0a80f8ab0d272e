#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "disparity_map.h"
#include "json.h"
#include "messages.h"
#include "numbers.h"
#include "options.h"

enum { SCALE, TRUTH_SCALE, MAX_RMS, MAX_BAD_HALF, MAX_BAD_ONE, JSON };

static const option options[] = {
    [SCALE] = {"scale", 0, false, "S", "8", "MAP holds disparity x S; a .pfm holds pixels whatever S is"},
    [TRUTH_SCALE] = {"truth-scale", 0, false, "S", "8", "the same of TRUTH"},
    [MAX_RMS] = {"max-rms", 0, false, "X", NULL, "exit with 1 if the rms error is above X pixels"},
    [MAX_BAD_HALF] = {"max-bad-0.5", 0, false, "P", NULL,
                      "exit with 1 if more than P percent are off by more than 0.5"},
    [MAX_BAD_ONE] = {"max-bad-1.0", 0, false, "P", NULL, "exit with 1 if more than P percent are off by more than 1"},
    [JSON] = {"json", 0, false, NULL, NULL, "print one JSON object"},
};

static const command_line line = {
    .name = "score",
    .operands = {"MAP", "TRUTH"},
    .about =
        "Compares a disparity map with the truth, over the pixels that have a value in both: the root mean square\n"
        "error in pixels (rms), and the percentage of pixels that are off by more than 0.5 and 1 pixel (bad-0.5,\n"
        "bad-1.0).\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo score disparity.png truth.png --scale 8 --truth-scale 8\n"
                "  qstereo score disparity.pfm truth.png --truth-scale 16 --max-bad-1.0 10\n",
};

/* The errors, or most errors allowed, in the order of MAX_RMS, MAX_BAD_HALF, MAX_BAD_ONE. */
enum { ERRORS = 3 };

/* The eq. (6) and (7) of the paper from the library's exact sums. */
static void errors_of(const qs_score *score, uint32_t scale, uint32_t truth_scale, double errors[ERRORS])
{
    double pixels = (double)score->pixels;
    double squares = ldexp((double)score->squares_high, 64) + (double)score->squares_low;
    errors[0] = sqrt(squares / pixels) / ((double)scale * truth_scale);
    errors[1] = 100.0 * (double)score->bad_half / pixels;
    errors[2] = 100.0 * (double)score->bad_one / pixels;
}

static void print_json(const qs_score *score, const double errors[ERRORS])
{
    static const char *const keys[ERRORS] = {"rms", "bad_0_5", "bad_1_0"};
    json_begin();
    json_count("pixels", score->pixels);
    for (size_t i = 0; i < ERRORS; i++) {
        if (score->pixels > 0) {
            json_real(keys[i], errors[i]);
        } else {
            json_null(keys[i]);
        }
    }
    json_end();
}

static void print_score(const qs_score *score, const double errors[ERRORS])
{
    printf("pixels   %" PRIu64 "\n", score->pixels);
    if (score->pixels > 0) {
        printf("rms      %.4f pixels\nbad-0.5  %.2f %%\nbad-1.0  %.2f %%\n", errors[0], errors[1], errors[2]);
    }
}

/* Returns ANSWER_NO where an error is above what is allowed. */
static int check_limits(const char *name, const arguments *given, const double errors[ERRORS],
                        const double most[ERRORS])
{
    int status = DONE;
    for (size_t i = 0; i < ERRORS; i++) {
        if (given->values[MAX_RMS + i] != NULL && errors[i] > most[i]) {
            status = fail(ANSWER_NO, name, "%s is %.6g, above %s", options[MAX_RMS + i].name + 4, errors[i],
                          given->values[MAX_RMS + i]);
        }
    }
    return status;
}

static int score_maps(const arguments *given, const qs_map *map, const qs_map *truth, const double most[ERRORS])
{
    const char *name = input_name(given->operands[0]), *truth_name = input_name(given->operands[1]);
    double errors[ERRORS] = {0, 0, 0};
    qs_score score;
    qs_status compared = qs_score_map(map, truth, &score);
    if (compared == QS_E_GEOMETRY) {
        return fail(BAD_INPUT, truth_name, "is %zu x %zu pixels, but %s is %zu x %zu", truth->width, truth->height,
                    name, map->width, map->height);
    }
    if (compared != QS_OK) {
        return fail_status(name, compared);
    }
    if (score.pixels > 0) {
        errors_of(&score, map->scale, truth->scale, errors);
    }
    if (given->values[JSON] != NULL) {
        print_json(&score, errors);
    } else {
        print_score(&score, errors);
    }
    if (score.pixels == 0) {
        return fail(ANSWER_NO, name, "no pixel has a value both here and in %s", truth_name);
    }
    return check_limits(name, given, errors, most);
}

static int read_and_score(const arguments *given, uint32_t scale, uint32_t truth_scale, const double most[ERRORS])
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
        status = number_read("--truth-scale", given.values[TRUTH_SCALE], 1, 65536, &truth_scale);
    }
    for (size_t i = 0; i < ERRORS && status == DONE; i++) {
        (void)snprintf(spelled, sizeof spelled, "--%s", options[MAX_RMS + i].name);
        if (given.values[MAX_RMS + i] != NULL) {
            status = threshold_read(spelled, given.values[MAX_RMS + i], &most[i]);
        }
    }
    return status == DONE ? read_and_score(&given, scale, truth_scale, most) : status;
}
