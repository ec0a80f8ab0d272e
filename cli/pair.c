#include "pair.h"

#include <string.h>

#include "pictures/picture_read.h"
#include "text/fail.h"
#include "text/names.h"
#include "text/numbers.h"

static int read_disparity(const char *text, qs_stereo *stereo)
{
    uint32_t range[2];
    if (!numbers_read(text, ':', range, 2) || range[1] > INT32_MAX) {
        return fail_usage("--disparity %s is not MIN:MAX, two whole numbers from 0 to %ld", text,
                          (long)INT32_MAX);
    }
    if (range[0] > range[1]) {
        return fail_usage("--disparity %s is empty: MIN is above MAX", text);
    }
    if (range[1] - range[0] >= QS_LABELS_MAX) {
        return fail_usage("--disparity %s has %lu labels: %u is the most", text,
                          (unsigned long)(range[1] - range[0]) + 1, QS_LABELS_MAX);
    }
    stereo->disparity_min = range[0];
    stereo->disparity_max = range[1];
    return DONE;
}

static int read_lambda(const char *text, qs_stereo *stereo)
{
    fraction lambda;
    decimal_status status = decimal_read(text, INT32_MAX, DECIMAL_DENOMINATOR_MAX, &lambda);
    if (status != DECIMAL_OK) {
        return decimal_fail("--lambda", text, status,
                            "any decimal number from 0 that is n/s in lowest terms, with s up to "
                            "1000000 and n up to 2147483647");
    }
    stereo->scale = lambda.denominator;
    stereo->weight = (int32_t)lambda.numerator;
    return DONE;
}

static int read_roi(const char *text, pair *asked)
{
    uint32_t roi[4];
    asked->whole = text == NULL;
    if (text == NULL) {
        return DONE;
    }
    if (!numbers_read(text, ',', roi, 4) || roi[2] == 0 || roi[3] == 0) {
        return fail_usage("--roi %s is not X,Y,W,H, four whole numbers with W and H from 1", text);
    }
    asked->stereo.x = roi[0];
    asked->stereo.y = roi[1];
    asked->stereo.width = roi[2];
    asked->stereo.height = roi[3];
    return DONE;
}

static int read_smoothness(const char *name, const char *truncation, qs_pairwise *pairwise)
{
    int value;
    TRY(name_read(&smoothness_names, name, "", &value));
    pairwise->smoothness = (qs_smoothness)value;
    if (truncation == NULL) {
        return DONE;
    }
    if (pairwise->smoothness == QS_POTTS) {
        return fail_usage(
            "--truncation goes with --smoothness linear or quadratic: potts has nothing to "
            "truncate");
    }
    return number_read("--truncation", truncation, 1, INT32_MAX, &pairwise->truncation);
}

int pair_read(const char *left, const char *right, const char *const *values, const char *weights,
              pair *asked)
{
    int cost = QS_COST_AD;
    uint32_t bits = 0;
    memset(asked, 0, sizeof *asked);
    asked->left = left;
    asked->right = right;
    asked->weights = weights;
    TRY(read_disparity(values[PAIR_DISPARITY], &asked->stereo));
    TRY(read_lambda(values[PAIR_LAMBDA], &asked->stereo));
    TRY(read_roi(values[PAIR_ROI], asked));
    TRY(name_read(&cost_names, values[PAIR_COST], "", &cost));
    TRY(read_smoothness(values[PAIR_SMOOTHNESS], values[PAIR_TRUNCATION], &asked->pairwise));
    if (values[PAIR_BITS] != NULL) {
        TRY(number_read("--bits", values[PAIR_BITS], 9, 16, &bits));
    }
    asked->bits = bits;
    asked->stereo.cost = (qs_cost)cost;
    return DONE;
}

/* Checks the geometry as the library does, so that a message can name what the user can mend. */
static int check_geometry(const pair *asked)
{
    const qs_stereo *stereo = &asked->stereo;
    const qs_image *left = &stereo->left, *right = &stereo->right;
    size_t end = asked->whole ? left->width : (size_t)stereo->x + stereo->width;
    if (left->width != right->width || left->height != right->height) {
        return fail(BAD_INPUT, input_name(asked->right),
                    "is %zu x %zu pixels, but %s is %zu x %zu: both pictures need the same size",
                    right->width, right->height, input_name(asked->left), left->width,
                    left->height);
    }
    if (end > left->width || (!asked->whole && (size_t)stereo->y + stereo->height > left->height)) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "is %zu x %zu pixels: --roi %lu,%lu,%lu,%lu does not fit inside", left->width,
                    left->height, (unsigned long)stereo->x, (unsigned long)stereo->y,
                    (unsigned long)stereo->width, (unsigned long)stereo->height);
    }
    if (end <= stereo->disparity_max) {
        return fail(BAD_INPUT, input_name(asked->left),
                    "%s ends at column %zu, which is too narrow for disparity %lu: no pixel would "
                    "have all its matches inside the right picture; lower --disparity%s",
                    asked->whole ? "the picture" : "--roi", end - 1,
                    (unsigned long)stereo->disparity_max,
                    asked->whole ? "" : " or move --roi to the right");
    }
    return DONE;
}

static int fail_encode(const pair *asked, qs_status status)
{
    const char *name = input_name(asked->left);
    if (status == QS_E_LIMIT) {
        return fail(
            BAD_INPUT, name,
            "sites x labels is more than %u variables: choose a smaller --roi or --disparity",
            QS_VARIABLES_MAX);
    }
    if (status == QS_E_OVERFLOW) {
        return fail(BAD_INPUT, name,
                    "the coefficients overflow (their sum is above 2^53): %schoose a smaller %s",
                    fewer_decimals(asked->weights, asked->stereo.scale), asked->weights);
    }
    return fail_status(name, status);
}

static int make_problem(pair *opened, budget *limit, qs_problem *problem)
{
    size_t size = qs_stereo_workspace(&opened->stereo);
    void *workspace = budget_take(limit, input_name(opened->left), size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status made = qs_stereo_problem(&opened->stereo, workspace, size, problem);
    if (made != QS_OK) {
        return fail_encode(opened, made);
    }
    problem->pairwise = opened->pairwise;
    return DONE;
}

int pair_open(pair *opened, budget *limit, qs_problem *problem)
{
    TRY(picture_read_grey(opened->left, opened->bits, limit, &opened->stereo.left));
    TRY(picture_read_grey(opened->right, opened->bits, limit, &opened->stereo.right));
    TRY(check_geometry(opened));
    return make_problem(opened, limit, problem);
}

int pair_encode(const pair *encoded, const qs_problem *problem, const qs_encode_options *options,
                budget *limit, const qs_sink *sink, uint64_t *size)
{
    size_t workspace_size = qs_encode_workspace(problem);
    void *workspace = budget_take(limit, input_name(encoded->left), workspace_size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status written = qs_encode(problem, options, sink, workspace, workspace_size, size);
    return written == QS_OK || written == QS_E_IO ? DONE : fail_encode(encoded, written);
}

int pair_lay_out(const pair *of, const qs_problem *problem, budget *limit, laid_out *made)
{
    return lay_out_problem(input_name(of->left), problem, of->weights, limit, made);
}
