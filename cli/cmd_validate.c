#include <inttypes.h>
#include <stdio.h>

#include "decimal.h"
#include "json.h"
#include "messages.h"
#include "numbers.h"
#include "options.h"
#include "survey.h"

enum { JSON, MEMORY_LIMIT };

static const option options[] = {
    [JSON] = JSON_OPTION,
    [MEMORY_LIMIT] = MEMORY_LIMIT_OPTION,
};

static const command_line line = {
    .name = "validate",
    .operands = {"P.qcf", "S.qsf"},
    .about =
        "Checks the samples of a QUBO: that they answer this very problem, how many are feasible "
        "(one-hot: every site has\n"
        "exactly one label; the other encodings: the bits are those of a labelling), and whether "
        "each energy is what\n"
        "the problem gives. Exits with 1 if no sample is feasible, with 3 if an energy is wrong.\n",
    .options = options,
    .option_count = sizeof options / sizeof options[0],
    .examples = "  qstereo validate p.qcf s.qsf\n"
                "  qstereo validate p.qcf s.qsf --json\n",
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
        json_units("best_energy", seen->best_energy, scale);
    } else {
        json_null("best_sample");
        json_null("best_energy");
    }
    if (samples->count > 0) {
        json_units("lowest_energy", seen->lowest_energy, scale);
    } else {
        json_null("lowest_energy");
    }
    json_truth("energies_agree", seen->wrong == 0);
    json_end();
}

static void print_lines(const answer *both, const survey *seen)
{
    const qs_samples_view *samples = &both->samples.view;
    char energy[DECIMAL_SIZE];
    printf("%" PRIu32 " sample%s (%" PRIu64 " occurrence%s) by %.*s\n", samples->count,
           plural(samples->count), seen->occurrences, plural(seen->occurrences),
           (int)samples->solver_size, samples->solver);
    printf("%" PRIu32 " feasible: %s\n", seen->feasible, feasible_means(&both->problem.qubo));
    if (seen->feasible > 0) {
        decimal_write(seen->best_energy, both->problem.scale, energy);
        printf("best: sample %" PRIu32 ", energy %s\n", seen->best, energy);
    }
    if (samples->count > 0) {
        decimal_write(seen->lowest_energy, both->problem.scale, energy);
        printf("lowest energy of all: %s\n", energy);
    }
    printf("energies %s\n", seen->wrong == 0 ? "agree" : "DO NOT agree");
}

static int validate(const answer *both, bool json, budget limit)
{
    survey seen;
    int status = survey_samples(both, limit, &seen);
    if (status != DONE) {
        return status;
    }
    if (json) {
        print_json(both, &seen);
    } else {
        print_lines(both, &seen);
    }
    status = survey_fail_wrong(both, &seen);
    if (status == DONE && seen.feasible == 0) {
        return fail(ANSWER_NO, both->samples.name, "no sample is feasible");
    }
    return status;
}

int cmd_validate(int argc, char **argv)
{
    arguments given;
    budget limit;
    answer both;
    int status;
    if (!options_read(&line, argc, argv, &given, &status)) {
        return status;
    }
    status = budget_read(given.values[MEMORY_LIMIT], &limit);
    if (status == DONE) {
        status = answer_open(given.operands[0], given.operands[1], &limit, &both);
    }
    if (status != DONE) {
        return status;
    }
    status = validate(&both, given.values[JSON] != NULL, limit);
    answer_close(&both);
    return status;
}
