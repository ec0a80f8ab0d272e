#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "pictures/map_errors.h"
#include "scores/score_files.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

enum { AS, HOLE, SCALE, TRUTH_SCALE, MAX_RMS, MAX_BAD_HALF, MAX_BAD_ONE, JSON, MEMORY_LIMIT };

static const option options[] = {
    [AS] = {"as", 0, false, "NAME", "disparity",
            "what the files hold: disparity, labels, picture, flow or boxes"},
    [HOLE] = {"hole", 0, false, "MASK", NULL,
              "with --as picture: also score the pixels where this picture is not 0"},
    [SCALE] = {"scale", 0, false, "S", "8", "OUT holds disparity x S; a .pfm always holds pixels"},
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

static int read_and_score(const job *at, uint32_t scale, uint32_t truth_scale,
                          const double most[ERRORS])
{
    const char *const *operands = at->given->operands;
    qs_map map, truth;
    int32_t *values = NULL, *truth_values = NULL;
    int status = map_read(operands[0], scale, &map, &values);
    if (status == DONE) {
        status = map_read(operands[1], truth_scale, &truth, &truth_values);
    }
    if (status == DONE) {
        status = score_maps(at, &map, &truth, most);
    }
    free(values);
    free(truth_values);
    return status;
}

/* Options that only disparity maps have must not be given for others. */
static int check_options(const job *at)
{
    for (size_t i = 0; i < at->given->given_count; i++) {
        size_t index = at->given->given[i].index;
        if (index >= SCALE && index <= MAX_BAD_ONE) {
            return fail_usage("--%s goes with --as disparity: leave it out", options[index].name);
        }
    }
    return DONE;
}

static int score_disparities(job *at)
{
    uint32_t scale, truth_scale;
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
    return read_and_score(at, scale, truth_scale, most);
}

static int run_score(job *at)
{
    const char *as = at->values[AS];
    if (strcmp(as, "disparity") == 0 && at->values[HOLE] == NULL) {
        return score_disparities(at);
    }
    TRY(check_options(at));
    return score_files(at, as, at->values[HOLE]);
}

const command cmd_score = {
    .line =
        {
            .name = "score",
            .operands = {"OUT", "TRUTH"},
            .about =
                "Compares what a command found with the truth.\n\n"
                "--as disparity: two disparity maps, over the pixels that have a value in both: "
                "the root mean square error in pixels (rms), and the percentage of pixels that are "
                "wrong by more than 0.5 and 1 pixel (bad-0.5, bad-1.0).\n\n"
                "--as labels: two grey pictures, or .npy, of classes: the intersection over union "
                "(iou), its mean over the classes that are in either, and the part of the pixels "
                "that are wrong (error_rate).\n\n"
                "--as picture: two pictures, as greys: psnr in decibel, and ssim (Wang et al. "
                "2004).\n\n"
                "--as flow: two fields, .flo, .npy or KITTI's .png, over the pixels that are known "
                "in "
                "both: the mean endpoint error in pixels (aepe) and the mean angular error in "
                "degrees (aae; Baker et al. 2011).\n\n"
                "--as boxes: two .csv: precision, recall, and the average precision (ap; "
                "Everingham et al. 2010), where a box is right if its IoU with a true one is 0.5 "
                "or more.\n",
            OPTIONS(options),
            .examples =
                "  qstereo score disparity.png truth.png --scale 8 --truth-scale 8\n"
                "  qstereo score disparity.pfm truth.png --truth-scale 16 --max-bad-1.0 10\n"
                "  qstereo score mask.png truth.png --as labels --json\n",
        },
    .summary = "compare a result with the truth",
    .run = run_score,
};
