#include "complexity.h"
#include "describe.h"
#include "messages.h"
#include "options.h"

enum { COMPLEXITY, JSON, MEMORY_LIMIT };

static const option options[] = {
    [COMPLEXITY] = {"complexity", 0, false, NULL, NULL,
                    "print what the problem of a .qcf takes in every encoding"},
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "info",
    .operands = {"FILE"},
    .about = "Says what a QUBO file (.qcf) or a samples file (.qsf) holds, after checking all of "
             "it. Energies and\n"
             "coefficients are in real units; those of a .qsf alone are in the integer units of "
             "its .qcf.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo info p.qcf\n"
                "  qstereo info s.qsf --json\n"
                "  qstereo info p.qcf --complexity\n",
};

static int info_samples(const char *path, file_bytes file, bool json)
{
    samples_file samples;
    int status = samples_take(path, file, &samples);
    if (status != DONE) {
        return status;
    }
    if (json) {
        describe_samples_json(&samples);
    } else {
        describe_samples(&samples);
    }
    file_free(&samples.file);
    return DONE;
}

static int info_problem(const char *path, file_bytes file, budget *limit, bool json)
{
    problem_file problem;
    int status = problem_take(path, file, limit, &problem);
    if (status != DONE) {
        return status;
    }
    status = problem_index(&problem, limit); /* which checks that the blocks fit their groups */
    if (status == DONE) {
        (json ? describe_problem_json : describe_problem)(&problem);
    }
    problem_close(&problem);
    return status;
}

static int info_complexity(const char *path, file_bytes file, budget *limit, bool json)
{
    problem_file problem;
    laid_out laid;
    int status = problem_take(path, file, limit, &problem);
    if (status != DONE) {
        return status;
    }
    status = laid_out_open(&problem, limit, &laid);
    if (status == DONE) {
        (json ? complexity_json : complexity_print)(&laid, *limit);
    }
    laid_out_close(&laid);
    problem_close(&problem);
    return status;
}

int cmd_info(int argc, char **argv)
{
    arguments given;
    budget limit;
    file_bytes file;
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    const char *path = given.operands[0];
    bool json = given.values[JSON] != NULL, complexity = given.values[COMPLEXITY] != NULL;
    status = budget_read(given.values[MEMORY_LIMIT], &limit);
    if (status == DONE) {
        status = file_read(path, &limit, &file);
    }
    if (status != DONE) {
        return status;
    }
    if (problem_is(&file)) {
        return (complexity ? info_complexity : info_problem)(path, file, &limit, json);
    }
    if (samples_are(&file) && !complexity) {
        return info_samples(path, file, json);
    }
    file_free(&file);
    return fail(BAD_INPUT, input_name(path),
                complexity ? "is not a .qcf file" : "is not a .qcf or .qsf file");
}
