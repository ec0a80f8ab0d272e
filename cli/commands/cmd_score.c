#include <stdio.h>

#include "command.h"
#include "pictures/map_errors.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

enum { SCALE, TRUTH_SCALE, MAX_RMS, MAX_BAD_HALF, MAX_BAD_ONE, JSON, MEMORY_LIMIT };

static const option options[] = {
    [SCALE] = {"scale", 0, false, "S", "8", "MAP holds disparity x S; a .pfm always holds pixels"},
    [TRUTH_SCALE] = {"truth-scale", 0, false, "S", "8", "the same for TRUTH"},
    [MAX_RMS] = {"max-rms", 0, false, "X", NULL, "exit with 1 if the rms error is above X pixels"},
    [MAX_BAD_HALF] = {"max-bad-0.5", 0, false, "P", NULL,
                      "exit with 1 if more than P percent are wrong by more than 0.5"},
    [MAX_BAD_ONE] = {"max-bad-1.0", 0, false, "P", NULL,
                     "exit with 1 if more than P percent are wrong by more than 1"},
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

/* The limits of the errors are in the order of the errors. Returns ANSWER_NO if an error is above
 * its limit. */
static int check_limits(const char *name, const job *at, const double errors[ERRORS],
                        const double most[ERRORS])
{
    int status = DONE;
    for (size_t i = 0; i < ERRORS; i++) {
        if (at->values[MAX_RMS + i] != NULL && errors[i] > most[i]) {
            status = fail(ANSWER_NO, name, "%s is %.6g, above %s", options[MAX_RMS + i].name + 4,
                          errors[i], at->values[MAX_RMS + i]);
        }
    }
    return status;
}

static int score_maps(const job *at, const qs_map *map, const qs_map *truth,
                      const double most[ERRORS])
{
    const char *name = input_name(at->given->operands[0]),
               *truth_name = input_name(at->given->operands[1]);
    map_errors errors;
    TRY(map_errors_find(name, map, truth_name, truth, &errors));
    if (at->json) {
        json_begin();
        map_errors_json(&errors);
        json_end();
    } else {
        map_errors_print(&errors);
    }
    if (errors.pixels == 0) {
        return fail(ANSWER_NO, name,
                    "no pixel has a value both here and in %s: compare maps that overlap",
                    truth_name);
    }
    return check_limits(name, at, errors.of, most);
}

static int run_score(job *at)
{
    uint32_t scale, truth_scale;
    qs_map map, truth;
    double most[ERRORS] = {0, 0, 0};
    char spelled[32];
    TRY(number_read("--scale", at->values[SCALE], 1, 65536, &scale));
    TRY(truth_scale_read(at->values[TRUTH_SCALE], &truth_scale));
    for (size_t i = 0; i < ERRORS; i++) {
        (void)snprintf(spelled, sizeof spelled, "--%s", options[MAX_RMS + i].name);
        if (at->values[MAX_RMS + i] != NULL) {
            TRY(threshold_read(spelled, at->values[MAX_RMS + i], &most[i]));
        }
    }
    TRY(map_read(at->given->operands[0], scale, &at->limit, &map));
    TRY(map_read(at->given->operands[1], truth_scale, &at->limit, &truth));
    return score_maps(at, &map, &truth, most);
}

const command cmd_score = {
    .line =
        {
            .name = "score",
            .operands = {"MAP", "TRUTH"},
            .about =
                "Compares a disparity map with the truth, over the pixels that have a value in "
                "both: the root mean square error in pixels (rms), and the percentage of pixels "
                "that are wrong by more than 0.5 and 1 pixel (bad-0.5, bad-1.0).\n",
            OPTIONS(options),
            .examples =
                "  qstereo score disparity.png truth.png --scale 8 --truth-scale 8\n"
                "  qstereo score disparity.pfm truth.png --truth-scale 16 --max-bad-1.0 10\n",
        },
    .summary = "compare a disparity map with the truth",
    .run = run_score,
};
