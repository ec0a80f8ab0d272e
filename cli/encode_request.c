#include "encode_request.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "decimal.h"
#include "messages.h"
#include "names.h"
#include "numbers.h"
#include "options.h"
#include "output.h"

enum { OUTPUT, DISPARITY, LAMBDA, ROI, COST, SMOOTHNESS, TRUNCATION, ENCODING, PENALTY, GAP, JSON };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "FILE", NULL, "the QUBO file (.qcf) to write, - is standard output"},
    [DISPARITY] = {"disparity", 0, false, "MIN:MAX", "0:15", "disparities to choose from, in pixels, both included"},
    [LAMBDA] = {"lambda", 0, false, "L", "20", "weight of the smoothness, an exact decimal number"},
    [ROI] = {"roi", 0, false, "X,Y,W,H", NULL, "window of the left picture to match (default all of it)"},
    [COST] = {"cost", 0, false, "NAME", "ad", "cost of a disparity: ad, the absolute difference of the greys"},
    [SMOOTHNESS] = {"smoothness", 0, false, "NAME", "potts",
                    "cost of neighbours that differ: potts, linear or quadratic"},
    [TRUNCATION] = {"truncation", 0, false, "T", NULL,
                    "most that linear or quadratic smoothness reaches (default no bound)"},
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "one-hot or one-hot-sparse (default one-hot-sparse for potts, else one-hot)"},
    [PENALTY] = {"penalty", 0, false, "NAME", "local",
                 "local (least proven, by site), paper (one alpha for all) or an alpha of your own"},
    [GAP] = {"gap", 0, false, "G", "1", "integer units from the optimum to any infeasible state with --penalty local"},
    [JSON] = {"json", 0, false, NULL, NULL, "print what info --json prints of the file"},
};

static const command_line line = {
    .name = "encode",
    .operands = {"LEFT", "RIGHT"},
    .about = "Turns a rectified stereo pair into a QUBO: a site for each pixel of the left picture, a label for each\n"
             "disparity d, which matches pixel (x, y) with (x - d, y) of the right picture. Pixels of which a match\n"
             "would lie outside the right picture are left out.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo encode left.png right.png -o p.qcf --disparity 0:15 --lambda 20\n"
                "  qstereo encode left.png right.png -o p.qcf --roi 160,120,40,40 --penalty paper\n",
};

static int read_disparity(const char *text, qs_stereo *stereo)
{
    uint32_t range[2];
    if (!numbers_read(text, ':', range, 2) || range[1] > INT32_MAX) {
        return fail_usage("--disparity %s: not MIN:MAX, two whole numbers from 0 to %ld", text, (long)INT32_MAX);
    }
    if (range[0] > range[1]) {
        return fail_usage("--disparity %s: empty, MIN is above MAX", text);
    }
    if (range[1] - range[0] >= QS_LABELS_MAX) {
        return fail_usage("--disparity %s: %lu labels, %u is the most", text, (unsigned long)(range[1] - range[0]) + 1,
                          QS_LABELS_MAX);
    }
    stereo->disparity_min = range[0];
    stereo->disparity_max = range[1];
    return DONE;
}

static int fail_decimal(const char *name, const char *text, decimal_status status, const char *held)
{
    const char *why = status == DECIMAL_GARBAGE     ? "not a decimal number"
                      : status == DECIMAL_NEGATIVE  ? "negative"
                      : status == DECIMAL_TOO_LARGE ? "too large"
                                                    : "too fine";
    return fail_usage("--%s %s: %s; it can be %s", name, text, why, held);
}

static int read_lambda(const char *text, qs_stereo *stereo)
{
    fraction lambda;
    decimal_status status = decimal_read(text, INT32_MAX, DECIMAL_DENOMINATOR_MAX, &lambda);
    if (status != DECIMAL_OK) {
        return fail_decimal(
            "lambda", text, status,
            "any decimal number from 0 that is n/s in lowest terms, with s up to 1000000 and n up to 2147483647");
    }
    stereo->scale = lambda.denominator;
    stereo->weight = (int32_t)lambda.numerator;
    return DONE;
}

static int read_roi(const char *text, encode_request *asked)
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
        return fail_usage("--truncation is for --smoothness linear and quadratic: potts has nothing to truncate");
    }
    return number_read("--truncation", truncation, 1, INT32_MAX, &pairwise->truncation);
}

static int read_encoding(const char *name, encode_request *asked)
{
    int value;
    if (name == NULL) {
        return DONE;
    }
    int status = name_read(&encoding_names, name, "", &value);
    if (status == DONE && value == QS_ONE_HOT_SPARSE && asked->pairwise.smoothness != QS_POTTS) {
        return fail_usage("--encoding one-hot-sparse holds --smoothness potts only: use --encoding one-hot");
    }
    asked->options.encoding = (qs_encoding)value;
    return status;
}

/* An alpha has to be a whole number of the integer units that lambda has chosen. */
static int read_alpha(const char *text, uint32_t scale, int64_t *alpha)
{
    char held[128];
    fraction given;
    decimal_status status = decimal_read(text, QS_ENERGY_MAX, scale, &given);
    if (status == DECIMAL_OK && scale % given.denominator != 0) {
        status = DECIMAL_TOO_FINE;
    }
    if (status == DECIMAL_OK && given.numerator > (uint64_t)QS_ENERGY_MAX / (scale / given.denominator)) {
        status = DECIMAL_TOO_LARGE;
    }
    (void)snprintf(held, sizeof held,
                   "any multiple above 0 of 1/%" PRIu32 ", the integer unit of this --lambda, up to 2^53 units", scale);
    if (status != DECIMAL_OK) {
        return fail_decimal("penalty", text, status, held);
    }
    *alpha = (int64_t)(given.numerator * (scale / given.denominator));
    return *alpha > 0 ? DONE : fail_usage("--penalty %s: not above 0", text);
}

static int read_penalty(const char *text, encode_request *asked)
{
    int value = QS_PENALTY_GIVEN;
    int status;
    if (strchr("0123456789.+-", text[0]) != NULL) {
        status = read_alpha(text, asked->stereo.scale, &asked->options.alpha);
    } else {
        status = name_read(&penalty_names, text, ", or a number", &value);
    }
    asked->options.penalty = (qs_penalty)value;
    return status;
}

static int read_values(const arguments *given, encode_request *asked)
{
    const char *const *values = given->values;
    int cost = QS_COST_AD;
    memset(asked, 0, sizeof *asked);
    asked->left = given->operands[0];
    asked->right = given->operands[1];
    asked->output = values[OUTPUT];
    asked->json = values[JSON] != NULL;
    int status = read_disparity(values[DISPARITY], &asked->stereo);
    if (status == DONE) {
        status = read_lambda(values[LAMBDA], &asked->stereo);
    }
    if (status == DONE) {
        status = read_roi(values[ROI], asked);
    }
    if (status == DONE) {
        status = name_read(&cost_names, values[COST], "", &cost);
    }
    if (status == DONE) {
        status = read_smoothness(values[SMOOTHNESS], values[TRUNCATION], &asked->pairwise);
    }
    if (status == DONE) {
        status = read_encoding(values[ENCODING], asked);
    }
    if (status == DONE) {
        status = read_penalty(values[PENALTY], asked);
    }
    if (status == DONE) {
        status = number_read("--gap", values[GAP], 1, INT32_MAX, &asked->options.gap);
    }
    asked->stereo.cost = (qs_cost)cost;
    if (status == DONE && asked->json && output_is_standard(asked->output)) {
        return fail_usage("--json and the file cannot both go to standard output");
    }
    return status;
}

bool encode_request_read(int argc, char **argv, encode_request *asked, int *status)
{
    arguments given;
    if (!options_read(&line, argc, argv, &given, status)) {
        return false;
    }
    *status = read_values(&given, asked);
    return *status == DONE;
}
