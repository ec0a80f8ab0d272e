#include "encode_request.h"

#include <string.h>

#include "messages.h"
#include "options.h"
#include "output.h"
#include "pair_options.h"

enum {
    OUTPUT,
    PAIR,
    ENCODING = PAIR + PAIR_OPTIONS,
    CODING,
    REDUCE = CODING + CODING_OPTIONS,
    REDUCING,
    JSON = REDUCING + REDUCING_OPTIONS,
    MEMORY_LIMIT
};

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "FILE", NULL,
                "the QUBO file (.qcf) to write, - is standard output"},
    [PAIR] = PAIR_OPTION_ROWS,
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "see above (default one-hot-sparse for potts, else one-hot)"},
    [CODING] = CODING_OPTION_ROWS(" (default local)", " (default 1)", ""),
    [REDUCE] =
        {"reduce", 0, false, NULL, NULL,
         "leave out labels that are proven to be in no optimum, as reduce does; with these two:"},
    [REDUCING] = REDUCING_OPTION_ROWS,
    [JSON] = {"json", 0, false, NULL, NULL, "print what info --json prints of the file"},
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "encode",
    .operands = {"LEFT", "RIGHT"},
    .about = "Turns a rectified stereo pair into a QUBO: a site for each pixel of the left "
             "picture, a label for each\n"
             "disparity d, which matches pixel (x, y) with (x - d, y) of the right picture. Pixels "
             "of which a match\n"
             "would lie outside the right picture are left out.\n"
             "\n"
             "one-hot is the paper's and holds every smoothness; one-hot-sparse and domain-wall "
             "(fewest variables) hold\n"
             "potts and linear, multiway-cut potts, st-cut and st-cut-arcs linear without "
             "truncation. one-hot-sparse has\n"
             "fewer terms than one-hot for potts; for linear without a small truncation it has "
             "more terms and larger\n"
             "penalties, so that domain-wall is the choice there.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples =
        "  qstereo encode left.png right.png -o p.qcf --disparity 0:15 --lambda 20\n"
        "  qstereo encode left.png right.png -o p.qcf --roi 160,120,40,40 --penalty paper\n"
        "  qstereo encode left.png right.png -o p.qcf --encoding domain-wall --truncate --gap 20\n"
        "  qstereo encode left.png right.png -o p.qcf --reduce --target 500 --encoding "
        "domain-wall\n",
};

static qs_encoding default_encoding(const pair *of)
{
    return of->pairwise.smoothness == QS_POTTS ? QS_ONE_HOT_SPARSE : QS_ONE_HOT;
}

static int read_coding(const char *const *values, encode_request *asked)
{
    const qs_stereo *stereo = &asked->pair.stereo;
    const coded_problem of = {
        .pairwise = asked->pair.pairwise,
        .labels = stereo->disparity_max - stereo->disparity_min + 1,
        .scale = stereo->scale,
        .encoding = default_encoding(&asked->pair),
        .penalty = QS_PENALTY_LOCAL,
        .gap = 1,
    };
    return coding_read(values[ENCODING], &values[CODING], &of, &asked->options);
}

static int read_reducing(const char *const *values, encode_request *asked)
{
    asked->reduce = values[REDUCE] != NULL;
    if (!asked->reduce && (values[REDUCING + REDUCING_TARGET] != NULL ||
                           values[REDUCING + REDUCING_TIME_LIMIT] != NULL)) {
        return fail_usage("--%s goes with --reduce",
                          values[REDUCING + REDUCING_TARGET] != NULL ? "target" : "time-limit");
    }
    return reducing_read(&values[REDUCING], asked->options.encode.encoding, &asked->how);
}

static int read_values(const arguments *given, encode_request *asked)
{
    const char *const *values = given->values;
    memset(asked, 0, sizeof *asked);
    asked->output = values[OUTPUT];
    asked->json = values[JSON] != NULL;
    int status = pair_read(given->operands[0], given->operands[1], &values[PAIR], ENCODE_WEIGHTS,
                           &asked->pair);
    if (status == DONE) {
        status = read_coding(values, asked);
    }
    if (status == DONE) {
        status = read_reducing(values, asked);
    }
    if (status == DONE) {
        status = budget_read(values[MEMORY_LIMIT], &asked->limit);
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
