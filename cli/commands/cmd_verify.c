#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "survey.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"

enum { JSON, MEMORY_LIMIT };

static const option options[] = {
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

/* What is being verified. */
typedef struct verified {
    const char *name; /* of the certificate, for messages */
    qs_certificate certificate;
    qs_verdict verdict;
    uint8_t *left; /* as of qs_certificate_check */
    int64_t energy; /* of the best sample; of the certificate's labelling where there are none */
} verified;

/* The answer is no. */
static void refute(verified *v, const char *why)
{
    if (v->verdict.valid) {
        v->verdict.valid = false;
        v->verdict.why = why;
    }
}

static int check_certificate(job *at, file_bytes file, verified *v)
{
    const problem_file *problem = &at->both.problem;
    const char *path = at->given->operands[2];
    qs_fault fault = {0, NULL};
    TRY(certificate_check(path, file, &v->certificate));
    v->name = input_name(path);
    size_t size = qs_certificate_workspace(&problem->index);
    v->left =
        budget_take(&at->limit, v->name, (size_t)problem->qubo.variables + problem->qubo.groups);
    void *workspace = v->left != NULL ? budget_take(&at->limit, v->name, size) : NULL;
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status status = qs_certificate_check(&problem->index, &v->certificate, workspace, size,
                                            &v->verdict, v->left, &fault);
    switch (status) {
    case QS_OK: v->energy = v->verdict.energy; return DONE;
    case QS_E_UNSUPPORTED:
        return fail(BAD_INPUT, problem->name,
                    "does not say which labels its variables stand for (chunk labl), so there is "
                    "no certificate of it");
    case QS_E_ENCODING:
        return fail(BAD_INPUT, problem->name,
                    "is not one-hot, one-hot-sparse or domain-wall: there is no certificate of it");
    default: return certificate_fail(path, file, status, &fault);
    }
}

/* The best sample must be as good as the certificate says. */
static int check_samples(job *at, file_bytes file, verified *v)
{
    survey seen;
    TRY(answer_take_samples(&at->both, at->given->operands[1], file));
    TRY(survey_samples(&at->both, &at->limit, &seen));
    TRY(survey_fail_wrong(&at->both, &seen));
    if (seen.feasible == 0) {
        refute(v, "no sample is a labelling");
        return DONE;
    }
    v->energy = seen.best_energy;
    if (seen.best_energy > v->certificate.energy) {
        refute(v, "the best sample costs more than the certificate states");
    }
    return DONE;
}

/* All labels that the certificate leaves must be left in the reduced problem. */
static int check_reduced(job *at, file_bytes file, verified *v)
{
    problem_file smaller;
    TRY(problem_check(at->given->operands[1], file, &at->limit, &smaller));
    if (v->verdict.valid &&
        !qs_certificate_covers(&at->both.problem.qubo, v->left, &smaller.qubo)) {
        refute(v, "a label has left the reduced problem that the certificate does not rule out");
    }
    return DONE;
}

static bool has_bound(const verified *v)
{
    return v->certificate.lower_bound != QS_NO_BOUND;
}

static void print_json(const verified *v, uint32_t scale)
{
    bool valid = v->verdict.valid;
    json_begin();
    json_truth("valid", valid);
    if (valid) {
        json_null("why");
    } else {
        json_name("why", v->verdict.why);
    }
    json_units("energy", v->energy, scale);
    json_units_or_null("lower_bound", has_bound(v), v->certificate.lower_bound, scale);
    json_truth("proven_optimal", valid && has_bound(v) && v->energy == v->certificate.lower_bound);
    json_count("stages", v->certificate.stages);
    json_end();
}

static void print_lines(const verified *v, uint32_t scale)
{
    char energy[DECIMAL_SIZE], bound[DECIMAL_SIZE];
    if (!v->verdict.valid) {
        return; /* the message says why */
    }
    decimal_write(v->energy, scale, energy);
    printf("valid: energy %s", energy);
    if (has_bound(v) && v->energy == v->certificate.lower_bound) {
        fputs(", proven optimal", stdout);
    } else if (has_bound(v)) {
        decimal_write(v->certificate.lower_bound, scale, bound);
        printf(", no labelling costs less than %s", bound);
    }
    printf("\n%" PRIu32 " stage%s\n", v->certificate.stages, plural(v->certificate.stages));
}

static int run_verify(job *at)
{
    file_bytes second, third;
    verified v;
    memset(&v, 0, sizeof v);
    TRY(job_open_problem(at));
    TRY(problem_index(&at->both.problem, &at->limit));
    TRY(file_read(at->given->operands[1], &at->limit, &second));
    TRY(file_read(at->given->operands[2], &at->limit, &third));
    TRY(check_certificate(at, third, &v));
    TRY(problem_is(&second) ? check_reduced(at, second, &v) : check_samples(at, second, &v));
    (at->json ? print_json : print_lines)(&v, at->both.problem.scale);
    return v.verdict.valid ? DONE : fail(ANSWER_NO, v.name, "is not valid: %s", v.verdict.why);
}

const command cmd_verify = {
    .line =
        {
            .name = "verify",
            .operands = {"P.qcf", "S.qsf", "C.qpf"},
            .about =
                "Checks a certificate of qstereo solve or reduce: that no labelling of the problem "
                "P.qcf costs less than the bound that it states, and that the best sample in S.qsf "
                "costs no more than it states. In the place of S.qsf may stand the .qcf that "
                "reduce has written: then it checks that every label that has left is in no "
                "optimum.\n\n"
                "The check reads the coefficients of P.qcf alone, and trusts no solver. Exits with "
                "0 if the certificate is valid, with 1 if it is not, with 3 if a file is "
                "damaged.\n",
            OPTIONS(options),
            .examples = "  qstereo verify p.qcf s.qsf c.qpf\n"
                        "  qstereo verify p.qcf small.qcf reduced.qpf --json\n",
        },
    .summary = "check the proof of a lower bound that solve or reduce has written",
    .run = run_verify,
};
