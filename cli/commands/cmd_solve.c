#include <inttypes.h>
#include <stdio.h>

#include "certifying.h"
#include "command.h"
#include "samples_output.h"
#include "solving.h"
#include "start.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"
#include "text/plain.h"

enum {
    OUTPUT,
    CERTIFICATE,
    SOLVER,
    SEARCH,
    STOPPING = SEARCH + SEARCH_OPTIONS,
    START = STOPPING + STOPPING_OPTIONS,
    TRACE,
    JSON,
    MEMORY_LIMIT
};

static const option options[] = {
    [OUTPUT] = {"output", 'o', true, "S.qsf", NULL, "samples file to write, - is standard output"},
    [CERTIFICATE] = CERTIFICATE_OPTION,
    [SOLVER] = SOLVER_OPTION,
    [SEARCH] = SEARCH_OPTION_ROWS,
    [STOPPING] = STOPPING_OPTION_ROWS,
    [START] = START_OPTION,
    [TRACE] = TRACE_OPTION,
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

typedef struct request {
    const solver *by;
    search how;
    trace course;
} request;

enum { INFO_SIZE = 512 };

/* What the samples file says about the solver. Energies are in integer units, as everywhere in the
 * file. */
static void write_info(const request *asked, const solved *found, char info[INFO_SIZE])
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
    (void)snprintf(info, INFO_SIZE,
                   "{\"parameters\": {\"iterations\": %s, \"time_limit\": %s, \"seed\": %" PRIu64
                   "}, "
                   "\"lower_bound\": %s, \"proven_optimal\": %s, \"iterations\": %" PRIu64
                   ", \"seconds\": %s}",
                   iterations, limit, asked->how.seed, bound,
                   solved_is_proven(found) ? "true" : "false", found->solution.iterations, seconds);
}

static int write_samples(const request *asked, const problem_file *problem, const solved *found,
                         output *out)
{
    char info[INFO_SIZE];
    const one_sample sample = {found->bits, found->qubo_energy, found->solver, info};
    write_info(asked, found, info);
    return samples_output_write(problem, &sample, out);
}

static void print_result(const job *at, const solved *found)
{
    const char *path = at->values[OUTPUT];
    uint32_t scale = at->both.problem.scale;
    if (at->json) {
        json_begin();
        solved_json(found, scale);
        json_end();
    } else if (!output_is_standard(path)) {
        job_print_outputs(at, path);
        solved_print(found, scale);
    }
}

static int solve_plainly(job *at, const request *asked, const laid_out *laid, solved *found)
{
    TRY(solve_problem(laid, asked->by, &asked->how, &at->limit, found));
    return solved_check(laid, asked->by, found);
}

/* Solves with a certificate. The lower bound is then the one that the certificate proves. */
static int solve_certified(job *at, request *asked, const laid_out *laid, solved *found)
{
    output *out;
    certifying proof;
    TRY(job_open_beside(at, "certificate", at->values[CERTIFICATE], &out));
    TRY(certifying_begin(laid, &at->limit, out, &proof));
    asked->how.witness = &proof.witness;
    int status = solve_plainly(at, asked, laid, found);
    if (status != DONE) {
        certifying_abandon(&proof);
        return status;
    }
    return certifying_end(&proof, asked->by->name, found->labelling, found->solution.energy,
                          &found->solution.lower_bound);
}

static int run_solve(job *at)
{
    request asked;
    laid_out laid;
    output *out;
    solved found;
    TRY(solver_read(at->values[SOLVER], &asked.by));
    TRY(search_read(&at->values[SEARCH], &asked.how));
    TRY(stopping_read(&at->values[STOPPING], &asked.how));
    TRY(job_open_problem(at));
    TRY(lay_out(&at->both.problem, &at->limit, &laid));
    TRY(start_read(at, at->values[START], &laid, &asked.how.start));
    bool certified = at->values[CERTIFICATE] != NULL;
    uint64_t work = solve_bytes(&laid, asked.by, asked.how.iterations);
    TRY(budget_need(&at->limit, laid.name, certified ? certifying_bytes(&laid, work) : work));
    TRY(job_open_output(at, at->values[OUTPUT], &out));
    TRY(trace_open(at, at->values[TRACE], laid.scale, &asked.course));
    asked.how.traced = &asked.course;
    TRY(certified ? solve_certified(at, &asked, &laid, &found)
                  : solve_plainly(at, &asked, &laid, &found));
    TRY(write_samples(&asked, &at->both.problem, &found, out));
    TRY(job_commit(at));
    print_result(at, &found);
    return DONE;
}

const command cmd_solve = {
    .line =
        {
            .name = "solve",
            .operands = {"P.qcf"},
            .about =
                "Solves a QUBO of qstereo encode or reduce (one-hot, one-hot-sparse, domain-wall) "
                "on this machine, as the labelling problem that it is, and writes the answer as a "
                "samples file with one sample.\n\n"
                "icm, anneal, swap and expansion go from labelling to labelling; bp and trws pass "
                "messages; best runs expansion, trws and moves together. cut takes only the "
                "pairwise costs that minimum cuts solve to the optimum. trws, cut and best also "
                "give an exact lower bound: no "
                "labelling has a lower energy. If the energy of the answer is equal to it, the "
                "answer is proven optimal.\n\n"
                "--certificate writes what proves the bound of trws, cut or best; qstereo verify "
                "checks it. The answer then states the bound that the certificate proves. Where "
                "best packs (detection, independent sets), its search may prove more, with more "
                "work than a certificate can ask for, and so may a search of a part that is too "
                "wide for one, or of windows of a large picture: a warning says so.\n\n"
                "--start begins with a labelling that is known, whoever found it: icm, anneal, "
                "swap, expansion, cut and best go on from it, and no solver's answer is above "
                "it. A file of reduce carries one, which is the default. The lower bound that it "
                "states counts for nothing here: bounds are computed anew.\n\n"
                "--time-limit is the time of the whole command, from start to answer. Ctrl-C ends "
                "the command "
                "without a file; with --keep-on-interrupt the first one stops the solver, and "
                "its best so far is written.\n",
            OPTIONS(options),
            .examples =
                "  qstereo solve p.qcf -o s.qsf\n"
                "  qstereo solve p.qcf -o s.qsf --solver trws --time-limit 2.5 --json\n"
                "  qstereo solve p.qcf -o s.qsf --certificate c.qpf\n"
                "  qstereo solve p.qcf -o s.qsf --start annealed.qsf\n"
                "  qstereo solve p.qcf -o s.qsf --solver anneal --iterations 2000 --seed 1\n",
        },
    .summary = "solve a .qcf on this machine, with a lower bound of every energy",
    .run = run_solve,
};
