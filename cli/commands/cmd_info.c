#include "command.h"
#include "complexity.h"
#include "describe.h"
#include "known_best.h"
#include "text/fail.h"

enum { COMPLEXITY, JSON, MEMORY_LIMIT };

static const option options[] = {
    [COMPLEXITY] = {"complexity", 0, false, NULL, NULL,
                    "print the size of the problem of a .qcf in every encoding"},
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static int info_samples(job *at, const char *path, file_bytes file)
{
    samples_file *samples = &at->both.samples;
    TRY(samples_check(path, file, samples));
    (at->json ? describe_samples_json : describe_samples)(samples);
    return DONE;
}

/* Indexes the problem too, because that checks that its blocks fit their groups. */
static int info_problem(job *at, const char *path, file_bytes file)
{
    problem_file *problem = &at->both.problem;
    known_best known;
    TRY(problem_check(path, file, &at->limit, problem));
    TRY(problem_index(problem, &at->limit));
    TRY(known_best_open(problem, &at->limit, &known));
    (at->json ? describe_problem_json : describe_problem)(problem, &known);
    return DONE;
}

static int info_complexity(job *at, const char *path, file_bytes file)
{
    laid_out laid;
    TRY(problem_check(path, file, &at->limit, &at->both.problem));
    TRY(lay_out(&at->both.problem, &at->limit, &laid));
    return (at->json ? complexity_json : complexity_print)(&laid, &at->limit);
}

static int run_info(job *at)
{
    const char *path = at->given->operands[0];
    bool complexity = at->values[COMPLEXITY] != NULL;
    file_bytes file;
    TRY(file_read(path, &at->limit, &file));
    if (problem_is(&file)) {
        return (complexity ? info_complexity : info_problem)(at, path, file);
    }
    if (samples_are(&file) && !complexity) {
        return info_samples(at, path, file);
    }
    return fail_kind(input_name(path), &file, complexity ? ".qcf" : ".qcf or .qsf");
}

const command cmd_info = {
    .line =
        {
            .name = "info",
            .operands = {"FILE"},
            .about = "Prints what a QUBO file (.qcf) or a samples file (.qsf) holds, after "
                     "checking all of it. Energies and coefficients are in real units; those of a "
                     ".qsf alone are in the integer units of its .qcf.\n",
            OPTIONS(options),
            .examples = "  qstereo info p.qcf\n"
                        "  qstereo info s.qsf --json\n"
                        "  qstereo info p.qcf --complexity\n",
        },
    .summary = "print what a .qcf or .qsf holds",
    .run = run_info,
};
