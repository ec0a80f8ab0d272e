#include <inttypes.h>
#include <stdio.h>

#include "command.h"
#include "survey.h"
#include "text/fail.h"
#include "text/json.h"
#include "text/numbers.h"
#include "text/plain.h"

enum { JSON, MEMORY_LIMIT };

static const option options[] = {
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static void print_json(const answer *both, const survey *seen)
{
    const qs_samples_view *samples = &both->samples.view;
    uint32_t scale = both->problem.scale;
    json_begin();
    json_count("samples", samples->count);
    json_count("occurrences", seen->occurrences);
    json_count("feasible", seen->feasible);
    if (seen->feasible > 0) {
        json_count("best_sample", seen->best);
    } else {
        json_null("best_sample");
    }
    json_units_or_null("best_energy", seen->feasible > 0, seen->best_energy, scale);
    json_units_or_null("lowest_energy", samples->count > 0, seen->lowest_energy, scale);
    json_truth("energies_agree", seen->wrong == 0);
    json_end();
}

static void print_lines(const answer *both, const survey *seen)
{
    const qs_samples_view *samples = &both->samples.view;
    char energy[DECIMAL_SIZE];
    printf("%" PRIu32 " sample%s (%" PRIu64 " occurrence%s) by %s\n", samples->count,
           plural(samples->count), seen->occurrences, plural(seen->occurrences),
           plain_text(samples->solver, samples->solver_size));
    printf("%" PRIu32 " feasible (a sample is feasible if %s)\n", seen->feasible,
           feasible_means(&both->problem.qubo));
    if (seen->feasible > 0) {
        decimal_write(seen->best_energy, both->problem.scale, energy);
        printf("best: sample %" PRIu32 ", energy %s\n", seen->best, energy);
    }
    if (samples->count > 0) {
        decimal_write(seen->lowest_energy, both->problem.scale, energy);
        printf("lowest energy of all samples: %s\n", energy);
    }
    printf("energies %s\n", seen->wrong == 0 ? "agree" : "DO NOT agree");
}

static int run_validate(job *at)
{
    answer *both = &at->both;
    survey seen;
    TRY(job_open_problem(at));
    TRY(job_open_samples(at));
    TRY(problem_index(&both->problem, &at->limit));
    TRY(survey_samples(both, &at->limit, &seen));
    (at->json ? print_json : print_lines)(both, &seen);
    TRY(survey_fail_wrong(both, &seen));
    return seen.feasible > 0 ? DONE : fail(ANSWER_NO, both->samples.name, "no sample is feasible");
}

const command cmd_validate = {
    .line =
        {
            .name = "validate",
            .operands = {"P.qcf", "S.qsf"},
            .about =
                "Checks the samples of a QUBO: that they belong to this problem, how many are "
                "feasible (in one-hot: every site has exactly one label; in the other encodings: "
                "the bits are those of a labelling), and that each stated energy is the one that "
                "the problem gives. Exits with 1 if no sample is feasible, with 3 if an energy is "
                "wrong.\n",
            OPTIONS(options),
            .examples = "  qstereo validate p.qcf s.qsf\n"
                        "  qstereo validate p.qcf s.qsf --json\n",
        },
    .summary = "check samples: are they feasible, are their energies right",
    .run = run_validate,
};
