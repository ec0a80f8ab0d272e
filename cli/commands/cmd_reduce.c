#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "certifying.h"
#include "command.h"
#include "encoding_choice.h"
#include "reducing.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

enum {
    OUTPUT,
    CERTIFICATE,
    REDUCING,
    ITERATIONS = REDUCING + REDUCING_OPTIONS,
    ENCODING,
    CODING,
    JSON = CODING + CODING_OPTIONS,
    MEMORY_LIMIT
};

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "SMALLER.qcf", NULL,
                "QUBO file to write, - is standard output"},
    [CERTIFICATE] = CERTIFICATE_OPTION,
    [REDUCING] = REDUCING_OPTION_ROWS,
    [ITERATIONS] = {"iterations", 0, false, "N", NULL,
                    "stop after N iterations of trws (default 2000)"},
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "encoding to write, one of those of encode (default that of P.qcf)"},
    [CODING] = CODING_OPTION_ROWS(" (default that of P.qcf, else local)",
                                  " (default that of P.qcf)", " (default as in P.qcf)"),
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

/* Which options go together depends on the problem. */
static int read_for(const job *at, reducing *how, qs_recode_options *coding)
{
    const char *const *values = at->values;
    const coded_problem of = coded_in_file(&at->both.problem);
    TRY(coding_read(values[ENCODING], &values[CODING], &of, coding));
    return reducing_read(&values[REDUCING], coding->encode.encoding, how);
}

static int read_iterations(const char *text, uint64_t *iterations)
{
    *iterations = 0;
    return text != NULL ? number64_read("--iterations", text, 1, UINT64_MAX, iterations) : DONE;
}

static void print_result(const job *at, const reduced *smaller, const laid_out *before,
                         const problem_file *after)
{
    const char *path = at->values[OUTPUT];
    if (at->json) {
        json_begin();
        reduced_json(smaller, before, after);
        json_end();
    } else if (!output_is_standard(path)) {
        printf("%s: %zu bytes\n", plain(path), after->file.size);
        reduced_print(smaller, before, encoding_name(before->labels.encoding), after);
    }
}

/* Reduces with a certificate. The lower bound is then the one that the certificate proves. */
static int reduce_certified(job *at, reducing *how, const laid_out *laid, reduced *smaller)
{
    output *out;
    certifying proof;
    TRY(job_open_output(at, at->values[CERTIFICATE], &out));
    TRY(certifying_begin(laid, &at->limit, out, &proof));
    how->witness = &proof.witness;
    int status = reduce_problem(laid, how, &at->limit, smaller);
    if (status != DONE) {
        certifying_abandon(&proof);
        return status;
    }
    return certifying_end(&proof, "reduce", smaller->labelling, smaller->found.upper_bound,
                          &smaller->found.lower_bound);
}

static int run_reduce(job *at)
{
    uint64_t iterations;
    laid_out laid;
    reducing how;
    qs_recode_options coding;
    output *out;
    reduced smaller;
    problem_file made;
    TRY(read_iterations(at->values[ITERATIONS], &iterations));
    TRY(job_open_problem(at));
    TRY(lay_out(&at->both.problem, &at->limit, &laid));
    TRY(read_for(at, &how, &coding));
    how.iterations = iterations;
    bool certified = at->values[CERTIFICATE] != NULL;
    uint64_t work = reduce_bytes(&laid);
    TRY(budget_need(&at->limit, laid.name, certified ? certifying_bytes(&laid, work) : work));
    TRY(job_open_output(at, at->values[OUTPUT], &out));
    TRY(certified ? reduce_certified(at, &how, &laid, &smaller)
                  : reduce_problem(&laid, &how, &at->limit, &smaller));
    coding.kept = smaller.kept;
    TRY(recode_problem(&laid, &coding, "--penalty or --gap", &at->limit, &made));
    output_write_file(out, &made.file);
    TRY(job_commit(at));
    print_result(at, &smaller, &laid, &made);
    return DONE;
}

const command cmd_reduce = {
    .line =
        {
            .name = "reduce",
            .operands = {"P.qcf"},
            .about =
                "Leaves out labels that are proven to be in no optimum, so that a solver has less "
                "to do. Every optimum stays, energies stay those of the whole problem, and decode "
                "gives the whole map.\n\n"
                "When the lower bound meets the energy, only labels that may tie are left. With "
                "--target the reduction stops earlier, at a hard problem of that size for an "
                "annealer.\n\n"
                "--certificate writes what proves that the labels are in no optimum; qstereo "
                "verify "
                "checks it.\n\n"
                "Reads one-hot, one-hot-sparse and domain-wall. The solver ilp of qstereo-bridge "
                "needs one-hot-sparse: --encoding one-hot-sparse writes a problem that was "
                "reduced as domain-wall once more for it.\n",
            OPTIONS(options),
            .examples = "  qstereo reduce p.qcf -o small.qcf\n"
                        "  qstereo reduce p.qcf -o small.qcf --target 500 \\\n"
                        "      --encoding domain-wall --truncate\n"
                        "  qstereo reduce core.qcf -o core-sparse.qcf --encoding one-hot-sparse\n",
        },
    .summary = "leave out of a .qcf what is proven, so that little is left to solve",
    .run = run_reduce,
};
