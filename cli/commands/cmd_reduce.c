#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "certifying.h"
#include "command.h"
#include "core_made.h"
#include "encoding_choice.h"
#include "reducing.h"
#include "samples_output.h"
#include "start.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/names.h"
#include "text/numbers.h"
#include "text/plain.h"

enum {
    OUTPUT,
    CERTIFICATE,
    SAMPLES,
    ANSWER,
    START,
    TRACE,
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
    [SAMPLES] = {"samples", 0, false, "CORE.qsf", NULL,
                 "also write the best labelling known, as a sample of SMALLER.qcf"},
    [ANSWER] = {"answer", 0, false, "ANSWER.qsf", NULL,
                "also write it as a sample of P.qcf, with the lower bound"},
    [START] = START_OPTION,
    [TRACE] = TRACE_OPTION,
    [REDUCING] = REDUCING_OPTION_ROWS,
    [ITERATIONS] = {"iterations", 0, false, "N", NULL,
                    "stop after N iterations of trws (default 2000)"},
    [ENCODING] = {"encoding", 0, false, "NAME", NULL,
                  "encoding to write, one of those of encode (default that of P.qcf; where "
                  "smoothness is not potts, the one with the fewest terms)"},
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

/* Says why labels that are decided are in the file all the same.
 *
 * left  variables that the reduction leaves */
static void print_detail(core_detail detail, uint64_t left)
{
    if (detail == CORE_SITES) {
        printf("%" PRIu64 " variables are left; a file of them alone would be larger than P.qcf, "
               "so in this one undecided sites have all their labels\n",
               left);
    } else if (detail == CORE_NOTHING) {
        puts("the file is P.qcf as it came: without what is decided it would be larger");
    }
}

static void print_result(const job *at, const reduced *smaller, const laid_out *before,
                         const problem_file *after, core_detail detail)
{
    const char *path = at->values[OUTPUT];
    if (at->json) {
        json_begin();
        reduced_json(smaller, before, after);
        json_end();
    } else if (!output_is_standard(path)) {
        job_print_outputs(at, path);
        printf("%s%zu bytes\n", at->out_count > 1 ? "the .qcf has " : "", after->file.size);
        reduced_print(smaller, before, encoding_name(before->labels.encoding), after);
        print_detail(detail, smaller->found.variables);
    }
}

/* Reduces with a certificate. The lower bound is then the one that the certificate proves. */
static int reduce_certified(job *at, const reducing *how, const laid_out *laid, reduced *smaller)
{
    output *out;
    certifying proof;
    TRY(job_open_beside(at, "certificate", at->values[CERTIFICATE], &out));
    TRY(certifying_begin(laid, &at->limit, out, &proof));
    reducing with_proof = *how;
    with_proof.witness = &proof.witness;
    int status = reduce_problem(laid, &with_proof, &at->limit, smaller);
    if (status != DONE) {
        certifying_abandon(&proof);
        return status;
    }
    return certifying_end(&proof, "reduce", smaller->labelling, smaller->found.upper_bound,
                          &smaller->found.lower_bound);
}

/* The outputs that are asked for beside the smaller problem; NULL = not this one. */
typedef struct found_outputs {
    output *samples, *answer;
} found_outputs;

static int open_found(job *at, found_outputs *outs)
{
    const char *samples = at->values[SAMPLES], *whole = at->values[ANSWER];
    *outs = (found_outputs){NULL, NULL};
    if (samples != NULL) {
        TRY(job_open_beside(at, "samples", samples, &outs->samples));
    }
    return whole != NULL ? job_open_beside(at, "answer", whole, &outs->answer) : DONE;
}

/* Writes the best labelling, which has kept labels only. Energies are in integer units, as
 * everywhere in the files. */
static int write_found(job *at, const reduced *smaller, problem_file *made,
                       const found_outputs *outs)
{
    enum { INFO_SIZE = 128 };
    char info[INFO_SIZE];
    const qs_reduction *found = &smaller->found;
    (void)snprintf(info, sizeof info, "{\"lower_bound\": %" PRId64 ", \"proven_optimal\": %s}",
                   found->lower_bound, found->lower_bound == found->upper_bound ? "true" : "false");
    if (outs->samples != NULL) {
        TRY(problem_index(made, &at->limit));
        TRY(samples_output_labelling(made, smaller->labelling, "reduce", info, &at->limit,
                                     outs->samples));
    }
    return outs->answer != NULL ? samples_output_labelling(&at->both.problem, smaller->labelling,
                                                           "reduce", info, &at->limit, outs->answer)
                                : DONE;
}

/* The command line does not say how to write the problem. */
static bool is_free(const job *at)
{
    const char *const *values = at->values;
    return values[ENCODING] == NULL && values[CODING + CODING_PENALTY] == NULL &&
           values[CODING + CODING_GAP] == NULL && values[REDUCING + REDUCING_TARGET] == NULL;
}

static int run_reduce(job *at)
{
    found_outputs outs;
    uint64_t iterations;
    laid_out laid;
    reducing how;
    qs_recode_options coding;
    output *out;
    trace course;
    reduced smaller;
    problem_file made;
    core_detail detail = CORE_LABELS;
    TRY(read_iterations(at->values[ITERATIONS], &iterations));
    TRY(job_open_problem(at));
    TRY(lay_out(&at->both.problem, &at->limit, &laid));
    TRY(read_for(at, &how, &coding));
    how.iterations = iterations;
    TRY(start_read(at, at->values[START], &laid, &how.start));
    bool certified = at->values[CERTIFICATE] != NULL;
    uint64_t work = reduce_bytes(&laid);
    TRY(budget_need(&at->limit, laid.name, certified ? certifying_bytes(&laid, work) : work));
    TRY(job_open_output(at, at->values[OUTPUT], &out));
    TRY(open_found(at, &outs));
    TRY(trace_open(at, at->values[TRACE], laid.scale, &course));
    how.traced = &course;
    TRY(certified ? reduce_certified(at, &how, &laid, &smaller)
                  : reduce_problem(&laid, &how, &at->limit, &smaller));
    coding.kept = smaller.kept;
    coding.best = smaller.labelling;
    coding.lower_bound = smaller.found.lower_bound;
    TRY(is_free(at) ? core_make(&laid, &coding, &smaller, &at->limit, &made, &detail)
                    : recode_problem(&laid, &coding, "--penalty or --gap", &at->limit, &made));
    output_write_file(out, &made.file);
    TRY(write_found(at, &smaller, &made, &outs));
    TRY(job_commit(at));
    print_result(at, &smaller, &laid, &made, detail);
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
                "gives the whole map. A file of more than 1 MiB is never larger than P.qcf: labels "
                "that are decided stay in it where leaving them out would take more room. If that "
                "holds for all of them the file is P.qcf as it came.\n\n"
                "When the lower bound meets the energy, only labels that may tie are left. With "
                "--target the reduction stops earlier, at a hard problem of that size for an "
                "annealer.\n\n"
                "--time-limit ends the search for labels to leave out, that long after the "
                "command began. "
                "Then SMALLER.qcf, and the certificate, are made and written whole, which takes "
                "longer the more is left: the limit does not cut that short.\n\n"
                "--certificate writes what proves that the labels are in no optimum; qstereo "
                "verify checks it. Where a part is too wide for a certificate, and more might be "
                "proven without one, a warning says so.\n\n"
                "--start begins with a labelling that is known: the better it is, the more can be "
                "proven. SMALLER.qcf, unless it is P.qcf as it came, carries the best labelling "
                "and "
                "the lower bound, so that solvers begin with it and qstereo-bridge knows where to "
                "end; --samples also writes the labelling as samples.\n\n"
                "Reads one-hot, one-hot-sparse and domain-wall. The solver ilp of qstereo-bridge "
                "needs one-hot-sparse: --encoding one-hot-sparse writes a problem that was "
                "reduced as domain-wall once more for it.\n",
            OPTIONS(options),
            .examples = "  qstereo reduce p.qcf -o small.qcf --certificate reduced.qpf\n"
                        "  qstereo reduce p.qcf -o small.qcf --target 500 \\\n"
                        "      --encoding domain-wall --truncate\n"
                        "  qstereo reduce core.qcf -o core-sparse.qcf --encoding one-hot-sparse\n",
        },
    .summary = "leave out of a .qcf what is proven, so that little is left to solve",
    .run = run_reduce,
};
