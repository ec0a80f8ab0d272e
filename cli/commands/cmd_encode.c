#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "describe.h"
#include "encoding_choice.h"
#include "pair.h"
#include "reducing.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

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
                "QUBO file (.qcf) to write, - is standard output"},
    [PAIR] = PAIR_OPTION_ROWS,
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "see above (default one-hot-sparse for potts, else one-hot)"},
    [CODING] = CODING_OPTION_ROWS(" (default local)", " (default 1)", ""),
    [REDUCE] = {"reduce", 0, false, NULL, NULL,
                "leave out labels that are proven to be in no optimum, as reduce does"},
    [REDUCING] = REDUCING_OPTION_ROWS,
    [JSON] = {"json", 0, false, NULL, NULL, "print what info --json prints of the file"},
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct encode_request {
    pair pair;
    qs_recode_options options; /* the encoding is never the default one */
    bool reduce;
    reducing how;
} encode_request;

/* The options that coefficients grow with. */
#define ENCODE_WEIGHTS "--lambda, --penalty, --gap or --truncation"

static int read_coding(const char *const *values, encode_request *asked)
{
    const qs_stereo *stereo = &asked->pair.stereo;
    const coded_problem of = {
        .pairwise = asked->pair.pairwise,
        .labels = stereo->disparity_max - stereo->disparity_min + 1,
        .scale = stereo->scale,
        .encoding = qs_encoding_default(&asked->pair.pairwise),
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
        return fail_usage("--%s goes with --reduce: add --reduce",
                          values[REDUCING + REDUCING_TARGET] != NULL ? "target" : "time-limit");
    }
    return reducing_read(&values[REDUCING], asked->options.encode.encoding, &asked->how);
}

static int read_request(const job *at, encode_request *asked)
{
    const char *const *operands = at->given->operands;
    memset(asked, 0, sizeof *asked);
    TRY(pair_read(operands[0], operands[1], &at->values[PAIR], ENCODE_WEIGHTS, &asked->pair));
    TRY(read_coding(at->values, asked));
    return read_reducing(at->values, asked);
}

static void print_outside(const encode_request *asked, uint32_t first)
{
    uint32_t left = asked->pair.whole ? 0 : asked->pair.stereo.x;
    if (first > left) {
        printf("%" PRIu32 " column%s on the left %s left out: a match would fall outside %s\n",
               first - left, plural(first - left), first - left == 1 ? "is" : "are",
               plain(asked->pair.right));
    }
}

/* Where the bytes of a stream go: to the output, and also to memory if they are to be described. */
typedef struct destination {
    output *out;
    bool keep;
    growing_file kept;
} destination;

static bool write_bytes(void *context, const void *bytes, size_t size)
{
    destination *to = context;
    return (!to->keep || growing_append(&to->kept, bytes, size)) &&
           output_write(to->out, bytes, size);
}

static void print_stream(const job *at, const encode_request *asked, const qs_problem *problem,
                         uint64_t size)
{
    uint32_t sites = qs_problem_sites(problem);
    uint64_t variables = (uint64_t)sites * problem->labels;
    printf("%s: %" PRIu32 " site%s x %" PRIu32 " label%s = %" PRIu64 " variable%s, %" PRIu64
           " bytes\n",
           plain(at->values[OUTPUT]), sites, plural(sites), problem->labels,
           plural(problem->labels), variables, plural(variables), size);
    print_outside(asked, problem->frame.x);
}

/* Opens what was written, for the JSON that was asked for. */
static int open_kept(job *at, destination *to, problem_file *written)
{
    const char *path = at->values[OUTPUT];
    TRY(growing_end(&to->kept, output_name(path), &at->limit));
    TRY(problem_check(path, to->kept.file, &at->limit, written));
    return problem_index(written, &at->limit);
}

/* Writes the problem in one pass. The whole of it is in memory only for --json. */
static int write_stream(job *at, const encode_request *asked, const qs_problem *problem)
{
    destination to = {.keep = at->json, .kept = growing_begin(at->limit.left)};
    const qs_sink sink = {write_bytes, &to};
    problem_file written;
    uint64_t size = 0;
    TRY(job_open_output(at, at->values[OUTPUT], &to.out));
    TRY(pair_encode(&asked->pair, problem, &asked->options.encode, &at->limit, &sink, &size));
    if (at->json) {
        TRY(open_kept(at, &to, &written));
    }
    TRY(job_commit(at));
    if (at->json) {
        describe_problem_json(&written);
    } else if (!output_is_standard(at->values[OUTPUT])) {
        print_stream(at, asked, problem, size);
    }
    return DONE;
}

/* A problem that is laid out before it is written. */
typedef struct building {
    laid_out whole; /* all labels */
    reduced smaller; /* if it was asked for */
    problem_file written;
} building;

static void print_built(const job *at, const encode_request *asked, const building *built)
{
    const qs_labels *labels = &built->written.qubo.labels;
    uint32_t variables = built->written.qubo.variables;
    printf("%s: %" PRIu32 " site%s x %" PRIu32 " label%s, %" PRIu32
           " variable%s in %s, %zu bytes\n",
           plain(at->values[OUTPUT]), labels->sites, plural(labels->sites), labels->labels,
           plural(labels->labels), variables, plural(variables), encoding_name(labels->encoding),
           built->written.file.size);
    print_outside(asked, labels->frame.x);
    if (asked->reduce) {
        reduced_print(&built->smaller, &built->whole, "sites x labels", &built->written);
    }
}

static int describe_built(job *at, const encode_request *asked, building *built)
{
    TRY(problem_index(&built->written, &at->limit));
    json_begin();
    describe_problem_keys(&built->written);
    if (asked->reduce) {
        reduced_json(&built->smaller, &built->whole, &built->written);
    }
    json_end();
    return DONE;
}

static int write_built(job *at, const encode_request *asked, const qs_problem *problem)
{
    qs_recode_options coding = asked->options;
    building built;
    output *out;
    memset(&built, 0, sizeof built);
    TRY(pair_lay_out(&asked->pair, problem, &at->limit, &built.whole));
    TRY(job_open_output(at, at->values[OUTPUT], &out));
    if (asked->reduce) {
        TRY(reduce_problem(&built.whole, &asked->how, &at->limit, &built.smaller));
        coding.kept = built.smaller.kept;
    }
    TRY(recode_problem(&built.whole, &coding, ENCODE_WEIGHTS, &at->limit, &built.written));
    output_write_file(out, &built.written.file);
    TRY(job_commit(at));
    if (at->json) {
        return describe_built(at, asked, &built);
    }
    if (!output_is_standard(at->values[OUTPUT])) {
        print_built(at, asked, &built);
    }
    return DONE;
}

static bool can_stream(const encode_request *asked)
{
    return qs_encoding_facts_of(asked->options.encode.encoding)->is_streamed &&
           !asked->options.truncate && !asked->reduce;
}

static int run_encode(job *at)
{
    encode_request asked;
    qs_problem problem;
    TRY(read_request(at, &asked));
    TRY(pair_open(&asked.pair, &at->limit, &problem));
    return (can_stream(&asked) ? write_stream : write_built)(at, &asked, &problem);
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
                "one-hot is the encoding of the paper and holds every smoothness. one-hot-sparse "
                "and domain-wall (fewest variables) hold potts and linear, multiway-cut potts, "
                "st-cut and st-cut-arcs linear without truncation. For potts, one-hot-sparse has "
                "fewer terms than one-hot. For linear it has more terms and larger penalties, "
                "unless the truncation is small: choose domain-wall there.\n\n"
                "--target and --time-limit go with --reduce.\n",
            OPTIONS(options),
            .examples =
                "  qstereo encode left.png right.png -o p.qcf --disparity 0:15 --lambda 20\n"
                "  qstereo encode left.png right.png -o p.qcf --roi 160,120,40,40 \\\n"
                "      --penalty paper\n"
                "  qstereo encode left.png right.png -o p.qcf --encoding domain-wall \\\n"
                "      --truncate --gap 20\n"
                "  qstereo encode left.png right.png -o p.qcf --reduce --target 500 \\\n"
                "      --encoding domain-wall\n",
        },
    .summary = "turn a stereo pair into a QUBO file (.qcf)",
    .run = run_encode,
};
