#include "encoding_made.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "describe.h"
#include "pair.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

typedef struct encode_request {
    const maker *maker;
    void *state; /* of the maker */
    made_problem made;
    qs_recode_options options; /* the encoding is never the default one */
    bool reduce;
    reducing how;
} encode_request;

/* The options that coefficients grow with. */
static const char *mend_of(const encode_request *asked, char text[128])
{
    (void)snprintf(text, 128, "--penalty, --gap, %s", asked->made.mend);
    return text;
}

static int read_coding(const job *at, encode_request *asked)
{
    const qs_problem *problem = &asked->made.problem;
    const coded_problem of = {
        .pairwise = problem->pairwise,
        .labels = problem->labels,
        .scale = problem->scale,
        .encoding = qs_encoding_default(&problem->pairwise),
        .penalty = QS_PENALTY_LOCAL,
        .gap = 1,
    };
    return coding_read(at->values[ENCODE_ENCODING], &at->values[ENCODE_CODING], &of,
                       &asked->options);
}

static int read_reducing(const job *at, encode_request *asked)
{
    const char *const *values = at->values;
    asked->reduce = values[ENCODE_REDUCE] != NULL;
    return reducing_read(&values[ENCODE_REDUCING], asked->options.encode.encoding, &asked->how);
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

/* Which columns of a stereo pair are left out. */
static void print_outside(const encode_request *asked)
{
    if (asked->maker == &pair_maker) {
        pair_print_outside(asked->state, &asked->made.problem);
    }
}

static void print_stream(const job *at, const encode_request *asked, uint64_t size)
{
    const qs_problem *problem = &asked->made.problem;
    uint32_t sites = qs_problem_sites(problem);
    uint64_t variables = (uint64_t)sites * problem->labels;
    printf("%s: %" PRIu32 " site%s x %" PRIu32 " label%s = %" PRIu64 " variable%s, %" PRIu64
           " bytes\n",
           plain(at->values[ENCODE_OUTPUT]), sites, plural(sites), problem->labels,
           plural(problem->labels), variables, plural(variables), size);
    print_outside(asked);
}

/* Opens what was written, for the JSON that was asked for. */
static int open_kept(job *at, destination *to, problem_file *written)
{
    const char *path = at->values[ENCODE_OUTPUT];
    TRY(growing_end(&to->kept, output_name(path), &at->limit));
    TRY(problem_check(path, to->kept.file, &at->limit, written));
    return problem_index(written, &at->limit);
}

/* Writes the problem in one pass. The whole of it is in memory only for --json. */
static int write_stream(job *at, const encode_request *asked)
{
    destination to = {.keep = at->json, .kept = growing_begin(at->limit.left, 0)};
    const qs_sink sink = {write_bytes, &to};
    problem_file written;
    char mend[128];
    uint64_t size = 0;
    to.kept.counts = true;
    TRY(job_open_output(at, at->values[ENCODE_OUTPUT], &to.out));
    TRY(made_encode(&asked->made, &asked->options.encode, mend_of(asked, mend), &at->limit, &sink,
                    &size));
    if (at->json) {
        TRY(open_kept(at, &to, &written));
    }
    TRY(job_commit(at));
    if (at->json) {
        const known_best nothing = {NULL, 0, QS_NO_BOUND};
        describe_problem_json(&written, &nothing);
    } else if (!output_is_standard(at->values[ENCODE_OUTPUT])) {
        print_stream(at, asked, size);
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
           plain(at->values[ENCODE_OUTPUT]), labels->sites, plural(labels->sites), labels->labels,
           plural(labels->labels), variables, plural(variables), encoding_name(labels->encoding),
           built->written.file.size);
    print_outside(asked);
    if (asked->reduce) {
        reduced_print(&built->smaller, &built->whole, "sites x labels", &built->written);
    }
}

static int describe_built(job *at, const encode_request *asked, building *built)
{
    known_best known;
    TRY(problem_index(&built->written, &at->limit));
    TRY(known_best_open(&built->written, &at->limit, &known));
    json_begin();
    describe_problem_keys(&built->written, &known);
    if (asked->reduce) {
        reduced_json(&built->smaller, &built->whole, &built->written);
    }
    json_end();
    return DONE;
}

static int write_built(job *at, const encode_request *asked)
{
    const made_problem *from = &asked->made;
    char mend[128];
    qs_recode_options coding = asked->options;
    building built;
    output *out;
    memset(&built, 0, sizeof built);
    TRY(lay_out_problem(from->name, &from->problem, from->mend, &at->limit, &built.whole));
    TRY(job_open_output(at, at->values[ENCODE_OUTPUT], &out));
    if (asked->reduce) {
        TRY(budget_need(&at->limit, built.whole.name, reduce_bytes(&built.whole)));
        TRY(reduce_problem(&built.whole, &asked->how, &at->limit, &built.smaller));
        coding.kept = built.smaller.kept;
        coding.best = built.smaller.labelling;
        coding.lower_bound = built.smaller.found.lower_bound;
    }
    TRY(recode_problem(&built.whole, &coding, mend_of(asked, mend), &at->limit, &built.written));
    output_write_file(out, &built.written.file);
    TRY(job_commit(at));
    if (at->json) {
        return describe_built(at, asked, &built);
    }
    if (!output_is_standard(at->values[ENCODE_OUTPUT])) {
        print_built(at, asked, &built);
    }
    return DONE;
}

static bool can_stream(const encode_request *asked)
{
    return qs_encoding_facts_of(asked->options.encode.encoding)->is_streamed &&
           !asked->options.truncate && !asked->reduce && asked->made.problem.allowed == NULL;
}

/* The options that have to go with the problem. */
static int read_options(const job *at, encode_request *asked)
{
    TRY(read_coding(at, asked));
    return read_reducing(at, asked);
}

int encode_made(job *at, const maker *by)
{
    encode_request asked = {.maker = by, .state = budget_take(&at->limit, NULL, by->size)};
    if (asked.state == NULL) {
        return NO_RESOURCE;
    }
    TRY(by->read(at->given->operands, &at->values[ENCODE_MAKER], asked.state));
    if (by->plan != NULL) {
        by->plan(asked.state, &asked.made.problem);
        TRY(read_options(at, &asked));
    }
    TRY(by->open(asked.state, &at->limit, &asked.made));
    if (by->plan == NULL) {
        TRY(read_options(at, &asked));
    }
    return (can_stream(&asked) ? write_stream : write_built)(at, &asked);
}
