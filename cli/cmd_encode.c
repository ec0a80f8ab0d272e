#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "describe.h"
#include "encode_request.h"
#include "json.h"
#include "messages.h"
#include "names.h"
#include "numbers.h"
#include "output.h"
#include "recoding.h"

static void print_outside(const encode_request *asked, uint32_t first)
{
    uint32_t left = asked->pair.whole ? 0 : asked->pair.stereo.x;
    if (first > left) {
        printf("%" PRIu32 " column%s on the left %s: a match would fall outside %s\n", first - left,
               plural(first - left), first - left == 1 ? "is no site" : "are no sites",
               asked->pair.right);
    }
}

/* Where the bytes of a stream go: to the output, and to memory too where they are to be described.
 */
typedef struct destination {
    output out;
    bool keep;
    growing_file kept;
} destination;

static bool write_bytes(void *context, const void *bytes, size_t size)
{
    destination *to = context;
    if (to->keep && !growing_append(&to->kept, bytes, size)) {
        to->out.error = ENOMEM;
        return false;
    }
    return output_write(&to->out, bytes, size);
}

static void print_stream(const encode_request *asked, const qs_problem *problem, uint64_t size)
{
    uint32_t sites = qs_problem_sites(problem);
    uint64_t variables = (uint64_t)sites * problem->labels;
    printf("%s: %" PRIu32 " site%s x %" PRIu32 " label%s = %" PRIu64 " variable%s, %" PRIu64
           " bytes\n",
           asked->output, sites, plural(sites), problem->labels, plural(problem->labels), variables,
           plural(variables), size);
    print_outside(asked, problem->frame.x);
}

/* Prints what was asked for, from the bytes as they were written. */
static int describe_kept(const encode_request *asked, destination *to)
{
    budget no_limit = {UINT64_MAX, 0};
    problem_file written;
    int status = problem_take(asked->output, to->kept.file, &no_limit, &written);
    to->kept.file = (file_bytes){NULL, 0};
    if (status == DONE) {
        status = problem_index(&written, &no_limit);
    }
    if (status == DONE) {
        describe_problem_json(&written);
    }
    problem_close(&written);
    return status;
}

/* In one pass, without the problem ever being in memory. */
static int write_stream(const encode_request *asked, const qs_problem *problem)
{
    destination to = {.keep = asked->json, .kept = growing_begin(UINT64_MAX)};
    qs_sink sink = {write_bytes, &to};
    uint64_t size = 0;
    int status = output_open(&to.out, asked->output);
    if (status != DONE) {
        return status;
    }
    status = pair_encode(&asked->pair, problem, &asked->options.encode, &sink, &size);
    bool whole = status == DONE && to.out.error == 0;
    if (whole && asked->json) {
        status = describe_kept(asked, &to);
    } else if (whole && !output_is_standard(asked->output)) {
        print_stream(asked, problem, size);
    }
    file_free(&to.kept.file);
    if (status != DONE) {
        output_abandon(&to.out);
        return status;
    }
    return output_commit(&to.out, 1); /* which reports refused bytes */
}

/* A problem that is laid out before it is written. */
typedef struct building {
    problem_file whole; /* all labels, one-hot */
    laid_out laid;
    reduced smaller; /* where it was asked for */
    problem_file written;
} building;

static void print_built(const encode_request *asked, const building *built)
{
    const qs_labels *labels = &built->written.qubo.labels;
    uint32_t variables = built->written.qubo.variables;
    printf("%s: %" PRIu32 " site%s x %" PRIu32 " label%s, %" PRIu32
           " variable%s in %s, %zu bytes\n",
           asked->output, labels->sites, plural(labels->sites), labels->labels,
           plural(labels->labels), variables, plural(variables),
           name_of(&encoding_names, (int)labels->encoding), built->written.file.size);
    print_outside(asked, labels->frame.x);
    if (asked->reduce) {
        reduced_print(&built->smaller, &built->whole, "sites x labels", &built->written);
    }
}

static int describe_built(const encode_request *asked, building *built, budget *limit)
{
    int status = problem_index(&built->written, limit);
    if (status == DONE) {
        json_begin();
        describe_problem_keys(&built->written);
        if (asked->reduce) {
            reduced_json(&built->smaller, &built->whole, &built->written);
        }
        json_end();
    }
    return status;
}

static int build(const encode_request *asked, building *built, budget *limit)
{
    qs_recode_options options = asked->options;
    int status = laid_out_open(&built->whole, limit, &built->laid);
    if (status == DONE && asked->reduce) {
        status = reduce_problem(&built->laid, &asked->how, limit, &built->smaller);
        options.kept = built->smaller.kept;
    }
    return status == DONE
               ? recode_problem(&built->laid, &options, ENCODE_WEIGHTS, limit, &built->written)
               : status;
}

/* Opens the output before the work, so that a long reduction is not in vain. */
static int write_built(const encode_request *asked, building *built, budget *limit)
{
    output out;
    int status = output_open(&out, asked->output);
    if (status != DONE) {
        return status;
    }
    status = build(asked, built, limit);
    if (status == DONE) {
        (void)output_write(&out, built->written.file.bytes,
                           built->written.file.size); /* a refusal is reported by the commit */
    }
    if (status == DONE && asked->json) {
        status = describe_built(asked, built, limit);
    } else if (status == DONE && !output_is_standard(asked->output)) {
        print_built(asked, built);
    }
    if (status != DONE) {
        output_abandon(&out);
        return status;
    }
    return output_commit(&out, 1);
}

/* The problem itself, in the form with the fewest terms and the smallest coefficients that it has.
 */
static qs_encode_options plain_encoding(const qs_problem *problem)
{
    bool sparse = encoding_holds(QS_ONE_HOT_SPARSE, &problem->pairwise, problem->labels);
    return (qs_encode_options){.encoding = sparse ? QS_ONE_HOT_SPARSE : QS_ONE_HOT,
                               .penalty = QS_PENALTY_MINIMAL};
}

static int encode_built(encode_request *asked, const qs_problem *problem)
{
    const qs_encode_options plain = plain_encoding(problem);
    budget limit = asked->limit;
    building built;
    memset(&built, 0, sizeof built);
    int status = pair_hold(&asked->pair, problem, &plain, &limit, &built.whole);
    if (status == DONE) {
        status = write_built(asked, &built, &limit);
    }
    problem_close(&built.written);
    reduced_free(&built.smaller);
    laid_out_close(&built.laid);
    problem_close(&built.whole);
    return status;
}

static bool can_stream(const encode_request *asked)
{
    qs_encoding encoding = asked->options.encode.encoding;
    return (encoding == QS_ONE_HOT || encoding == QS_ONE_HOT_SPARSE) && !asked->options.truncate &&
           !asked->reduce;
}

int cmd_encode(int argc, char **argv)
{
    encode_request asked;
    qs_problem problem;
    int status;
    if (!encode_request_read(argc, argv, &asked, &status)) {
        return status;
    }
    status = pair_open(&asked.pair, &problem);
    if (status == DONE) {
        status =
            can_stream(&asked) ? write_stream(&asked, &problem) : encode_built(&asked, &problem);
    }
    pair_close(&asked.pair);
    return status;
}
