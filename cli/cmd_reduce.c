#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "json.h"
#include "messages.h"
#include "names.h"
#include "numbers.h"
#include "options.h"
#include "output.h"
#include "recoding.h"
#include "reducing.h"

enum {
    OUTPUT,
    REDUCING,
    ITERATIONS = REDUCING + REDUCING_OPTIONS,
    ENCODING,
    CODING,
    JSON = CODING + CODING_OPTIONS,
    MEMORY_LIMIT
};

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "SMALLER.qcf", NULL,
                "the QUBO file to write, - is standard output"},
    [REDUCING] = REDUCING_OPTION_ROWS,
    [ITERATIONS] = {"iterations", 0, false, "N", NULL,
                    "stop after N iterations of trws (default 2000)"},
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "write this encoding, one of those of encode (default that of P.qcf)"},
    [CODING] = CODING_OPTION_ROWS(" (default P.qcf's, else local)", " (default P.qcf's)",
                                  " (default as P.qcf is)"),
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "reduce",
    .operands = {"P.qcf"},
    .about = "Leaves out what needs no solver: labels that are proven to be in no optimum. Every "
             "optimum stays, energies stay\n"
             "those of the whole problem, and decode gives the whole map. What is left is ties "
             "once the bound is tight; with\n"
             "--target a hard core of that size is left for an annealer. Reads one-hot, "
             "one-hot-sparse and domain-wall.\n"
             "For the bridge's --solver ilp write one-hot-sparse: --encoding turns a domain-wall "
             "core over.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo reduce p.qcf -o small.qcf\n"
                "  qstereo reduce p.qcf -o small.qcf --target 500 --encoding domain-wall "
                "--truncate --json\n"
                "  qstereo reduce core.qcf -o core-sparse.qcf --encoding one-hot-sparse\n",
};

typedef struct request {
    const char *output;
    const char *const *values;
    uint64_t iterations;
    bool json;
} request;

static int read_request(const arguments *given, request *asked)
{
    asked->values = given->values;
    asked->output = given->values[OUTPUT];
    asked->json = given->values[JSON] != NULL;
    asked->iterations = 0;
    if (asked->json && output_is_standard(asked->output)) {
        return fail_usage("--json and the file cannot both go to standard output");
    }
    const char *iterations = given->values[ITERATIONS];
    return iterations != NULL
               ? number64_read("--iterations", iterations, 1, UINT64_MAX, &asked->iterations)
               : DONE;
}

/* What goes with what depends on the problem. */
static int read_for(const request *asked, const problem_file *problem, reducing *how,
                    qs_recode_options *coding)
{
    const coded_problem of = coded_in_file(problem);
    int status = coding_read(asked->values[ENCODING], &asked->values[CODING], &of, coding);
    if (status == DONE) {
        status = reducing_read(&asked->values[REDUCING], coding->encode.encoding, how);
    }
    how->iterations = asked->iterations;
    return status;
}

static void print_result(const request *asked, const reduced *smaller, const problem_file *before,
                         const problem_file *after)
{
    if (asked->json) {
        json_begin();
        reduced_json(smaller, before, after);
        json_end();
    } else if (!output_is_standard(asked->output)) {
        printf("%s: %zu bytes\n", asked->output, after->file.size);
        reduced_print(smaller, before, name_of(&encoding_names, (int)before->qubo.labels.encoding),
                      after);
    }
}

static int reduce_and_write(const request *asked, const laid_out *laid, const reducing *how,
                            qs_recode_options *coding, budget *limit, output *out)
{
    reduced smaller;
    problem_file made;
    memset(&made, 0, sizeof made);
    int status = reduce_problem(laid, how, limit, &smaller);
    coding->kept = smaller.kept;
    if (status == DONE) {
        status = recode_problem(laid, coding, "--penalty or --gap", limit, &made);
    }
    if (status == DONE) {
        (void)output_write(out, made.file.bytes,
                           made.file.size); /* a refusal is reported by the commit */
        print_result(asked, &smaller, laid->problem, &made);
    }
    problem_close(&made);
    reduced_free(&smaller);
    return status;
}

/* Opens the output before the work, so that a long search is not in vain. */
static int reduce_open(const request *asked, problem_file *problem, budget *limit)
{
    laid_out laid;
    reducing how;
    qs_recode_options coding;
    output out;
    int status = laid_out_open(problem, limit, &laid);
    if (status == DONE) {
        status = read_for(asked, problem, &how, &coding);
    }
    if (status == DONE) {
        status = output_open(&out, asked->output);
    }
    if (status == DONE) {
        status = reduce_and_write(asked, &laid, &how, &coding, limit, &out);
        if (status == DONE) {
            status = output_commit(&out, 1);
        } else {
            output_abandon(&out);
        }
    }
    laid_out_close(&laid);
    return status;
}

int cmd_reduce(int argc, char **argv)
{
    arguments given;
    request asked;
    budget limit;
    problem_file problem;
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    status = read_request(&given, &asked);
    if (status == DONE) {
        status = budget_read(given.values[MEMORY_LIMIT], &limit);
    }
    if (status == DONE) {
        status = problem_open(given.operands[0], &limit, &problem);
    }
    if (status != DONE) {
        return status;
    }
    status = reduce_open(&asked, &problem, &limit);
    problem_close(&problem);
    return status;
}
