#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "decimal.h"
#include "json.h"
#include "messages.h"
#include "options.h"
#include "output.h"
#include "solving.h"

enum { OUTPUT, SOLVER, SEARCH, JSON = SEARCH + SEARCH_OPTIONS, MEMORY_LIMIT };

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "S.qsf", NULL,
                "the samples file to write, - is standard output"},
    [SOLVER] = SOLVER_OPTION,
    [SEARCH] = SEARCH_OPTION_ROWS,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "solve",
    .operands = {"P.qcf"},
    .about = "Solves a QUBO of qstereo encode or reduce (one-hot, one-hot-sparse, domain-wall) on "
             "this machine, as the labelling\n"
             "problem that it is, and writes the answer as a samples file of one sample. icm, "
             "anneal, swap and expansion move\n"
             "from labelling to labelling, bp and trws pass messages; trws and best (expansion, "
             "trws and moves together) also\n"
             "give a lower bound of every energy, which is exact: where it meets the energy, that "
             "is proven optimal. cut takes\n"
             "only the pairwise costs that minimum cuts solve to the optimum.\n"
             "Ctrl-C ends the command without a file.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo solve p.qcf -o s.qsf\n"
                "  qstereo solve p.qcf -o s.qsf --solver trws --time-limit 2.5 --json\n"
                "  qstereo solve p.qcf -o s.qsf --solver anneal --iterations 2000 --seed 1\n",
};

typedef struct request {
    const char *output;
    const solver *by;
    search how;
    bool json;
} request;

static int read_request(const arguments *given, request *asked)
{
    const char *const *values = given->values;
    int status = solver_read(values[SOLVER], &asked->by);
    asked->output = values[OUTPUT];
    asked->json = values[JSON] != NULL;
    if (status == DONE) {
        status = search_read(&values[SEARCH], &asked->how);
    }
    if (status == DONE && asked->json && output_is_standard(asked->output)) {
        return fail_usage("--json and the file cannot both go to standard output");
    }
    return status;
}

enum { INFO_SIZE = 512 };

/* What the samples file says of the solver; energies in integer units as everywhere in the file. */
static size_t write_info(const request *asked, const solved *found, char info[INFO_SIZE])
{
    char iterations[24] = "null", limit[DECIMAL_SIZE] = "null", bound[24] = "null",
         seconds[DECIMAL_SIZE];
    if (asked->how.iterations > 0) {
        (void)snprintf(iterations, sizeof iterations, "%" PRIu64, asked->how.iterations);
    }
    if (asked->how.time_limit > 0) {
        decimal_write(asked->how.time_limit, 1000000, limit);
    }
    if (solved_has_bound(found)) {
        (void)snprintf(bound, sizeof bound, "%" PRId64, found->solution.lower_bound);
    }
    decimal_write(found->microseconds, 1000000, seconds);
    int size = snprintf(
        info, INFO_SIZE,
        "{\"parameters\": {\"iterations\": %s, \"time_limit\": %s, \"seed\": %" PRIu64 "}, "
        "\"lower_bound\": %s, \"proven_optimal\": %s, \"iterations\": %" PRIu64
        ", \"seconds\": %s}",
        iterations, limit, asked->how.seed, bound, solved_is_proven(found) ? "true" : "false",
        found->solution.iterations, seconds);
    return (size_t)size;
}

static bool write_bytes(void *context, const void *bytes, size_t size)
{
    return output_write(context, bytes, size);
}

static int write_samples(const request *asked, const problem_file *problem, const solved *found,
                         output *out)
{
    char info[INFO_SIZE];
    const qs_record record = {found->qubo_energy, 1, QS_NO_CHAINS};
    qs_samples samples = {
        .variables = problem->qubo.variables,
        .count = 1,
        .solver = found->solver,
        .solver_size = strlen(found->solver),
        .info = info,
        .info_size = write_info(asked, found, info),
        .records = &record,
        .bits = found->bits,
    };
    const qs_sink sink = {write_bytes, out};
    qs_digest(problem->file.bytes, problem->file.size, samples.problem);
    qs_status written = qs_samples_write(&samples, &sink, NULL);
    /* Refused bytes are reported by the commit. */
    return written == QS_OK || written == QS_E_IO ? DONE : fail_status(out->name, written);
}

static void print_result(const request *asked, const problem_file *problem, const solved *found)
{
    if (asked->json) {
        json_begin();
        solved_json(found, problem->scale);
        json_end();
    } else if (!output_is_standard(asked->output)) {
        printf("%s: ", asked->output);
        solved_print(found, problem->scale);
    }
}

static int solve_and_write(const request *asked, const laid_out *problem, const budget *limit,
                           output *out)
{
    solved found;
    int status = solve_problem(problem, asked->by, &asked->how, *limit, &found);
    if (status != DONE) {
        return status;
    }
    status = solved_check(problem, &found);
    if (status == DONE) {
        status = write_samples(asked, problem->problem, &found, out);
    }
    if (status == DONE) {
        print_result(asked, problem->problem, &found);
    }
    solved_free(&found);
    return status;
}

/* Opens the output before the work, so that a long search is not in vain. */
static int solve_open(const request *asked, problem_file *problem, budget *limit)
{
    laid_out laid;
    output out;
    int status = laid_out_open(problem, limit, &laid);
    if (status == DONE) {
        status = output_open(&out, asked->output);
    }
    if (status == DONE) {
        status = solve_and_write(asked, &laid, limit, &out);
        if (status == DONE) {
            status = output_commit(&out, 1);
        } else {
            output_abandon(&out);
        }
    }
    laid_out_close(&laid);
    return status;
}

int cmd_solve(int argc, char **argv)
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
    status = solve_open(&asked, &problem, &limit);
    problem_close(&problem);
    return status;
}
