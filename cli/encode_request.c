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
#include "pair_options.h"

enum { OUTPUT, PAIR, ENCODING = PAIR + PAIR_OPTIONS, PENALTY, GAP, JSON };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "FILE", NULL, "the QUBO file (.qcf) to write, - is standard output"},
    [PAIR] = PAIR_OPTION_ROWS,
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "one-hot or one-hot-sparse (default one-hot-sparse for potts, else one-hot)"},
    [PENALTY] = {"penalty", 0, false, "NAME", "local",
                 "local (least proven, by site), paper (one alpha for all) or an alpha of your own"},
    [GAP] = {"gap", 0, false, "G", NULL,
             "integer units from the optimum to any infeasible state with --penalty local (default 1)"},
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

static int read_encoding(const char *name, encode_request *asked)
{
    int value;
    if (name == NULL) {
        return DONE;
    }
    int status = name_read(&encoding_names, name, "", &value);
    if (status == DONE && value == QS_ONE_HOT_SPARSE && asked->pair.pairwise.smoothness != QS_POTTS) {
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
        return decimal_fail("--penalty", text, status, held);
    }
    *alpha = (int64_t)(given.numerator * (scale / given.denominator));
    return *alpha > 0 ? DONE : fail_usage("--penalty %s: not above 0", text);
}

static int read_penalty(const char *text, encode_request *asked)
{
    int value = QS_PENALTY_GIVEN;
    int status;
    if (strchr("0123456789.+-", text[0]) != NULL) {
        status = read_alpha(text, asked->pair.stereo.scale, &asked->options.alpha);
    } else {
        status = name_read(&penalty_names, text, ", or a number", &value);
    }
    asked->options.penalty = (qs_penalty)value;
    return status;
}

static int read_gap(const char *text, encode_request *asked)
{
    asked->options.gap = 1;
    if (text == NULL) {
        return DONE;
    }
    if (asked->options.penalty != QS_PENALTY_LOCAL) {
        return fail_usage("--gap goes with --penalty local: no other keeps a gap");
    }
    return number_read("--gap", text, 1, INT32_MAX, &asked->options.gap);
}

static int read_values(const arguments *given, encode_request *asked)
{
    const char *const *values = given->values;
    memset(asked, 0, sizeof *asked);
    asked->output = values[OUTPUT];
    asked->json = values[JSON] != NULL;
    int status = pair_read(given->operands[0], given->operands[1], &values[PAIR],
                           "--lambda, --penalty, --gap or --truncation", &asked->pair);
    if (status == DONE) {
        status = read_encoding(values[ENCODING], asked);
    }
    if (status == DONE) {
        status = read_penalty(values[PENALTY], asked);
    }
    if (status == DONE) {
        status = read_gap(values[GAP], asked);
    }
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
