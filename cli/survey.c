#include "survey.h"

#include <inttypes.h>
#include <string.h>

#include "text/numbers.h"
#include "text/fail.h"

qs_status sample_labels(const qs_index *index, const uint8_t *bits, uint16_t *labelling,
                        int64_t *energy)
{
    qs_status status = qs_sample_decode(index, bits, labelling);
    if (status == QS_OK) {
        *energy = qs_qubo_energy(index, bits) + qs_sample_trimmed(index->qubo, labelling);
    }
    return status;
}

/* `labelling` is room for one, if the costs were truncated, else NULL. */
static void look_at(const answer *looked_at, uint32_t sample, uint16_t *labelling, survey *seen)
{
    const qs_index *index = &looked_at->problem.index;
    const uint8_t *bits = qs_samples_bits(&looked_at->samples.view, sample);
    qs_record record = qs_samples_record(&looked_at->samples.view, sample);
    int64_t energy = qs_qubo_energy(index, bits);
    seen->occurrences += record.occurrences;
    if (sample == 0 || energy < seen->lowest_energy) {
        seen->lowest_energy = energy;
    }
    if (energy != record.energy && seen->wrong++ == 0) {
        seen->first_wrong = sample;
        seen->stated = record.energy;
        seen->found = energy;
    }
    bool feasible = labelling != NULL ? sample_labels(index, bits, labelling, &energy) == QS_OK
                                      : qs_sample_infeasible(index, bits) == 0;
    if (feasible && (seen->feasible++ == 0 || energy < seen->best_energy)) {
        seen->best = sample;
        seen->best_energy = energy;
    }
}

int survey_samples(const answer *looked_at, budget *limit, survey *seen)
{
    const qs_qubo *qubo = &looked_at->problem.qubo;
    uint16_t *labelling = NULL;
    memset(seen, 0, sizeof *seen);
    if (qubo->has_labels && qubo->labels.trimmed_bytes > 0) {
        size_t size = sizeof *labelling * qubo->labels.sites;
        labelling = budget_take(limit, looked_at->problem.name, size);
        if (labelling == NULL) {
            return NO_RESOURCE;
        }
    }
    for (uint32_t sample = 0; sample < looked_at->samples.view.count; sample++) {
        look_at(looked_at, sample, labelling, seen);
    }
    return DONE;
}

const char *feasible_means(const qs_qubo *qubo)
{
    qs_encoding encoding = qubo->has_labels ? qubo->labels.encoding : QS_ONE_HOT;
    return qs_encoding_facts_of(encoding)->feasible;
}

int survey_fail_wrong(const answer *looked_at, const survey *seen)
{
    char stated[DECIMAL_SIZE], found[DECIMAL_SIZE];
    if (seen->wrong == 0) {
        return DONE;
    }
    decimal_write(seen->stated, looked_at->problem.scale, stated);
    decimal_write(seen->found, looked_at->problem.scale, found);
    return fail(BAD_INPUT, looked_at->samples.name,
                "sample %" PRIu32 " states the energy %s, but its energy in %s is %s (%" PRIu32
                " of %" PRIu32 " samples are wrong): solve this problem again",
                seen->first_wrong, stated, looked_at->problem.name, found, seen->wrong,
                looked_at->samples.view.count);
}
