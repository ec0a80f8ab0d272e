#include <stdio.h>
#include <string.h>

#include "command.h"
#include "pictures/map_errors.h"
#include "scores/score_files.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

enum {
    AS,
    HOLE,
    BOXES,
    SCALE,
    NO_VALUE,
    TRUTH_SCALE,
    TRUTH_NO_VALUE,
    MASK,
    MAX_RMS,
    MAX_BAD_HALF,
    MAX_BAD_ONE,
    MIN_DENSITY,
    JSON,
    MEMORY_LIMIT
};

/* Errors that have a limit; they are in the order of their options. */
enum { LIMITED = ERROR_BAD_ONE + 1 };

static const option options[] = {
    [AS] = {"as", 0, false, "NAME", "disparity",
            "what the files hold: disparity, labels, picture, flow or boxes"},
    [HOLE] = {"hole", 0, false, "MASK", NULL,
              "with --as picture: also score the pixels where this picture is not 0"},
    [BOXES] = {"boxes", 0, false, "BOXES.csv", NULL,
               "with --as boxes: OUT is a list of decode, of which of these boxes to keep"},
    [SCALE] = {"scale", 0, false, "S", "8", "OUT holds disparity x S; a .pfm always holds pixels"},
    [NO_VALUE] = {"no-value", 0, false, "V", NULL, "in OUT " NO_VALUE_HELP},
    [TRUTH_SCALE] = {"truth-scale", 0, false, "S", "8", "the same for TRUTH"},
    [TRUTH_NO_VALUE] = TRUTH_NO_VALUE_OPTION,
    [MASK] = {"mask", 0, false, "MASK", NULL,
              "count only pixels that are white here, as those visible in both pictures"},
    [MAX_RMS] = {"max-rms", 0, false, "X", NULL, "exit with 1 if the rms error is above X pixels"},
    [MAX_BAD_HALF] = {"max-bad-0.5", 0, false, "P", NULL,
                      "exit with 1 if more than P percent are wrong by more than 0.5"},
    [MAX_BAD_ONE] = {"max-bad-1.0", 0, false, "P", NULL,
                     "exit with 1 if more than P percent are wrong by more than 1"},
    [MIN_DENSITY] = {"min-density", 0, false, "P", NULL,
                     "exit with 1 if OUT has a value at less than P percent of TRUTH's pixels"},
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

/* What the errors are held against. */
typedef struct limits {
    double most[LIMITED];
    double density;
} limits;

/* Returns ANSWER_NO if an error is above its limit, or the density below it. */
static int check_limits(const char *name, const job *at, const map_errors *errors,
                        const limits *held)
{
    int status = DONE;
    for (size_t i = 0; i < LIMITED; i++) {
        if (at->values[MAX_RMS + i] != NULL && errors->of[i] > held->most[i]) {
            status = fail(ANSWER_NO, name, "%s is %.6g, above %s", options[MAX_RMS + i].name + 4,
                          errors->of[i], at->values[MAX_RMS + i]);
        }
    }
    if (at->values[MIN_DENSITY] != NULL && errors->density < held->density) {
        status = fail(ANSWER_NO, name, "density is %.6g, below %s", errors->density,
                      at->values[MIN_DENSITY]);
    }
    return status;
}

static int score_maps(const job *at, const qs_map *map, const qs_map *truth, const limits *held)
{
    const char *name = input_name(at->given->operands[0]),
               *truth_name = input_name(at->given->operands[1]);
    map_errors errors;
    TRY(map_errors_find(name, map, truth_name, truth, &errors));
    if (at->json) {
        json_begin();
        map_errors_json(&errors);
        map_errors_json_more(&errors);
        json_end();
    } else {
        map_errors_print(&errors);
        map_errors_print_more(&errors);
    }
    if (errors.pixels == 0) {
        return fail(ANSWER_NO, name,
                    "no pixel has a value both here and in %s: compare maps that overlap",
                    truth_name);
    }
    map_errors_warn(name, &errors);
    return check_limits(name, at, &errors, held);
}

static int read_limits(const char *const *values, limits *held)
{
    char spelled[32];
    *held = (limits){.density = 0};
    for (size_t i = 0; i < LIMITED; i++) {
        (void)snprintf(spelled, sizeof spelled, "--%s", options[MAX_RMS + i].name);
        if (values[MAX_RMS + i] != NULL) {
            TRY(threshold_read(spelled, values[MAX_RMS + i], &held->most[i]));
        }
    }
    return values[MIN_DENSITY] != NULL
               ? threshold_read("--min-density", values[MIN_DENSITY], &held->density)
               : DONE;
}

/* Options that only disparity maps have must not be given for others. */
static int check_options(const job *at)
{
    for (size_t i = 0; i < at->given->given_count; i++) {
        size_t index = at->given->given[i].index;
        if (index >= SCALE && index <= MIN_DENSITY) {
            return fail_usage("--%s goes with --as disparity: leave it out", options[index].name);
        }
    }
    return DONE;
}

static int score_disparities(job *at)
{
    const char *const *values = at->values, *const *operands = at->given->operands;
    map_form form, truth_form;
    limits held;
    qs_map map, truth;
    TRY(map_form_read("--scale", values[SCALE], "--no-value", values[NO_VALUE], &form));
    TRY(truth_form_read(values[TRUTH_SCALE], values[TRUTH_NO_VALUE], &truth_form));
    TRY(read_limits(values, &held));
    TRY(map_read(operands[0], &form, &at->limit, &map));
    TRY(map_read(operands[1], &truth_form, &at->limit, &truth));
    if (values[MASK] != NULL) {
        TRY(map_apply_mask(values[MASK], &at->limit, &truth));
    }
    return score_maps(at, &map, &truth, &held);
}

static int run_score(job *at)
{
    const char *as = at->values[AS];
    const score_options more = {at->values[HOLE], at->values[BOXES]};
    if (strcmp(as, "disparity") == 0 && more.hole == NULL && more.boxes == NULL) {
        return score_disparities(at);
    }
    TRY(check_options(at));
    return score_files(at, as, &more);
}

const command cmd_score = {
    .line =
        {
            .name = "score",
            .operands = {"OUT", "TRUTH"},
            .about =
                "Compares what a command found with the truth.\n\n"
                "--as disparity: two disparity maps, over the pixels that have a value in "
                "both: the root mean square error in pixels (rms), and the percentage of pixels "
                "that are wrong by more than 0.5, 1 and 2 pixels (bad-0.5, bad-1.0, bad-2.0); the "
                "average error; those wrong by more than 3 pixels and 5 percent (D1, as in "
                "KITTI); and the share of TRUTH's pixels at which OUT has a value (density).\n\n"
                "In a map of whole numbers 0 says no value and 1 disparity 0, unless the option "
                "for no value says otherwise. TIFFs may hold signed numbers or floats; floats "
                "are pixels, as in a .pfm.\n\n"
                "--as labels: two grey pictures, or .npy, of classes: the intersection over union "
                "(iou), its mean over the classes that are in either, and the part of the pixels "
                "that are wrong (error_rate).\n\n"
                "--as picture: two pictures, as greys: psnr in decibel, and ssim (Wang et al. "
                "2004).\n\n"
                "--as flow: two fields, .flo, .npy or KITTI's .png, over the pixels that are known "
                "in both: the mean endpoint error in pixels (aepe) and the mean angular error in "
                "degrees (aae; Baker et al. 2011).\n\n"
                "--as boxes: two .csv: precision, recall, and the average precision (ap; "
                "Everingham et al. 2010), where a box is right if its IoU with a true one is 0.5 "
                "or more. With --boxes OUT is the list box,keep that decode writes.\n",
            OPTIONS(options),
            .examples =
                "  qstereo score disparity.png truth.png --scale 8 --truth-scale 8\n"
                "  qstereo score disparity.pfm truth.png --truth-scale 16 --max-bad-1.0 10\n"
                "  qstereo score sgbm.tiff truth.pfm --scale 16 --no-value -16\n"
                "  qstereo score mask.png truth.png --as labels --json\n",
        },
    .summary = "compare a result with the truth",
    .run = run_score,
};
