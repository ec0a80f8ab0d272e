#include "pair_options.h"

#include <string.h>

#include "messages.h"
#include "names.h"
#include "numbers.h"

static int read_disparity(const char *text, qs_stereo *stereo)
{
    uint32_t range[2];
    if (!numbers_read(text, ':', range, 2) || range[1] > INT32_MAX) {
        return fail_usage("--disparity %s: not MIN:MAX, two whole numbers from 0 to %ld", text,
                          (long)INT32_MAX);
    }
    if (range[0] > range[1]) {
        return fail_usage("--disparity %s: empty, MIN is above MAX", text);
    }
    if (range[1] - range[0] >= QS_LABELS_MAX) {
        return fail_usage("--disparity %s: %lu labels, %u is the most", text,
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
        return fail_usage("--roi %s: not X,Y,W,H, four whole numbers with W and H from 1", text);
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
    int status = name_read(&smoothness_names, name, "", &value);
    if (status != DONE) {
        return status;
    }
    pairwise->smoothness = (qs_smoothness)value;
    if (truncation == NULL) {
        return DONE;
    }
    if (pairwise->smoothness == QS_POTTS) {
        return fail_usage(
            "--truncation is for --smoothness linear and quadratic: potts has nothing to truncate");
    }
    return number_read("--truncation", truncation, 1, INT32_MAX, &pairwise->truncation);
}

int pair_read(const char *left, const char *right, const char *const *values, const char *weights,
              pair *asked)
{
    int cost = QS_COST_AD;
    memset(asked, 0, sizeof *asked);
    asked->left = left;
    asked->right = right;
    asked->weights = weights;
    int status = read_disparity(values[PAIR_DISPARITY], &asked->stereo);
    if (status == DONE) {
        status = read_lambda(values[PAIR_LAMBDA], &asked->stereo);
    }
    if (status == DONE) {
        status = read_roi(values[PAIR_ROI], asked);
    }
    if (status == DONE) {
        status = name_read(&cost_names, values[PAIR_COST], "", &cost);
    }
    if (status == DONE) {
        status =
            read_smoothness(values[PAIR_SMOOTHNESS], values[PAIR_TRUNCATION], &asked->pairwise);
    }
    asked->stereo.cost = (qs_cost)cost;
    return status;
}
