#include <string.h>

#include "encoding_made.h"
#include "makers/detecting.h"
#include "makers/displacing.h"
#include "makers/labelling.h"
#include "makers/restoring.h"
#include "makers/segmenting.h"
#include "makers/uai.h"
#include "pair.h"
#include "text/fail.h"
#include "text/names.h"

static const option stereo_options[] = {ENCODE_OPTION_ROWS, [ENCODE_MAKER] = PAIR_OPTION_ROWS};
static const option label_options[] = {ENCODE_OPTION_ROWS, [ENCODE_MAKER] = LABELLING_OPTION_ROWS};
static const option restore_options[] = {ENCODE_OPTION_ROWS,
                                         [ENCODE_MAKER] = RESTORING_OPTION_ROWS};
static const option segment_options[] = {ENCODE_OPTION_ROWS,
                                         [ENCODE_MAKER] = SEGMENTING_OPTION_ROWS};
static const option flow_options[] = {ENCODE_OPTION_ROWS, [ENCODE_MAKER] = FLOW_OPTION_ROWS};
static const option register_options[] = {ENCODE_OPTION_ROWS,
                                          [ENCODE_MAKER] = REGISTER_OPTION_ROWS};
static const option detect_options[] = {ENCODE_OPTION_ROWS};
static const option uai_options[] = {ENCODE_OPTION_ROWS, [ENCODE_MAKER] = UAI_OPTION_ROWS};

static int run_label(job *at)
{
    return encode_made(at, &labelling_maker);
}

static int run_restore(job *at)
{
    return encode_made(at, &restoring_maker);
}

static int run_segment(job *at)
{
    return encode_made(at, &segmenting_maker);
}

static int run_displace(job *at)
{
    return encode_made(at, &displacing_maker);
}

static int run_detect(job *at)
{
    return encode_made(at, &detecting_maker);
}

static int run_uai(job *at)
{
    return encode_made(at, &uai_maker);
}

#define PROBLEM_COMMAND(operand, second, may_lack, described, rows, doing, example)                \
    {.line = {.name = "encode",                                                                    \
              .operands = {operand, second},                                                       \
              .optional = may_lack,                                                                \
              .about = described,                                                                  \
              OPTIONS(rows),                                                                       \
              .examples = "  qstereo encode --problem " example "\n"},                             \
     .summary = "",                                                                                \
     .run = doing}

static const command label = PROBLEM_COMMAND(
    "COSTS.npy", NULL, 0,
    "Turns any labelling problem, given as arrays of numpy, into a QUBO: qstereo label solves it "
    "in one go, and its --help describes the arrays.\n",
    label_options, run_label, "label costs.npy -o p.qcf --smoothness linear --lambda 3");
static const command restore = PROBLEM_COMMAND(
    "NOISY", NULL, 0,
    "Turns the restoration of a noisy picture, or the filling of its holes, into a QUBO: qstereo "
    "restore solves it in one go. Greys are labels: --step makes them fewer.\n",
    restore_options, run_restore, "restore noisy.png -o p.qcf --step 16");
static const command segment =
    PROBLEM_COMMAND("PHOTO", "STROKES", 1,
                    "Turns a segmentation into a QUBO: qstereo segment solves it in one go.\n",
                    segment_options, run_segment, "segment photo.png strokes.png -o p.qcf");
static const command flow = PROBLEM_COMMAND(
    "FIRST", "SECOND", 0, "Turns an optical flow into a QUBO: qstereo flow solves it in one go.\n",
    flow_options, run_displace, "flow first.png second.png -o p.qcf --radius 2");
static const command registration = PROBLEM_COMMAND(
    "FIXED", "MOVING", 0,
    "Turns a registration into a QUBO: qstereo register solves it in one go.\n", register_options,
    run_displace, "register fixed.png moving.png -o p.qcf --radius 2");
static const command detect = PROBLEM_COMMAND(
    "BOXES.csv", NULL, 0,
    "Turns the choice among overlapping boxes into a QUBO: qstereo detect solves it in one go.\n",
    detect_options, run_detect, "detect boxes.csv -o p.qcf");

static const command uai = PROBLEM_COMMAND(
    "NET.uai", NULL, 0,
    "Turns the most probable state of a pairwise Markov network of the UAI format into a QUBO: the "
    "cost of a factor's entry is -log of it, and a value whose own factor is 0 is forbidden.\n",
    uai_options, run_uai, "uai net.uai -o p.qcf --scale 10000");

static const struct {
    const char *problem;
    const command *command;
} problems[] = {{"stereo", &cmd_encode}, {"label", &label}, {"restore", &restore},
                {"segment", &segment},   {"flow", &flow},   {"register", &registration},
                {"detect", &detect},     {"uai", &uai}};
enum { PROBLEMS = sizeof problems / sizeof problems[0] };

/* The argument of --problem before the command line is read, because it decides how that is read;
 * NULL = none. The last one counts. */
static const char *problem_given(int argc, char **argv)
{
    const char *given = NULL;
    for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strncmp(argv[i], "--problem=", 10) == 0) {
            given = argv[i] + 10;
        } else if (strcmp(argv[i], "--problem") == 0 && i + 1 < argc) {
            given = argv[i + 1];
        }
    }
    return given;
}

const command *encode_variant(int argc, char **argv)
{
    const char *given = problem_given(argc, argv);
    for (size_t i = 0; given != NULL && i < PROBLEMS; i++) {
        if (strcmp(problems[i].problem, given) == 0) {
            return problems[i].command;
        }
    }
    return &cmd_encode;
}

/* A problem of another name ends here, too. */
static int run_stereo(job *at)
{
    named names[PROBLEMS];
    int value;
    for (int i = 0; i < PROBLEMS; i++) {
        names[i] = (named){problems[i].problem, i};
    }
    const name_table table = {"problem", names, PROBLEMS, PROBLEMS};
    TRY(name_read(&table, at->values[ENCODE_PROBLEM], "", &value));
    return encode_made(at, &pair_maker);
}

const command cmd_encode = {
    .line =
        {
            .name = "encode",
            .operands = {"LEFT", "RIGHT"},
            .about =
                "Turns a rectified stereo pair into a QUBO. Each pixel of the left picture is a "
                "site, and each disparity d is a label: it matches pixel (x, y) with (x - d, y) of "
                "the right picture. A pixel is left out if one of its matches would lie outside "
                "the right picture.\n\n"
                "one-hot (the encoding of the paper) and domain-wall (fewest variables) hold every "
                "smoothness, one-hot-sparse potts and linear, multiway-cut potts, "
                "st-cut and st-cut-arcs linear without truncation. For potts, one-hot-sparse has "
                "fewer terms than one-hot. For linear it has more terms and larger penalties, "
                "unless the truncation is small: choose domain-wall there.\n\n"
                "--target and --time-limit go with --reduce.\n",
            OPTIONS(stereo_options),
            .examples =
                "  qstereo encode left.png right.png -o p.qcf --disparity 0:15 --lambda 20\n"
                "  qstereo encode left.png right.png -o p.qcf --roi 90,60,40,40 \\\n"
                "      --penalty paper\n"
                "  qstereo encode left.png right.png -o p.qcf --encoding domain-wall \\\n"
                "      --truncate --gap 20\n"
                "  qstereo encode left.png right.png -o p.qcf --reduce --target 500 \\\n"
                "      --encoding domain-wall\n",
        },
    .summary = "turn a stereo pair into a QUBO file (.qcf)",
    .run = run_stereo,
};
