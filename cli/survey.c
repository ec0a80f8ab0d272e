#include "survey.h"

#include <inttypes.h>

#include "decimal.h"
#include "messages.h"

static void look_at(const answer *looked_at, uint32_t sample, survey *seen)
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
    if (qs_sample_infeasible(index, bits) == 0 && (seen->feasible++ == 0 || energy < seen->best_energy)) {
        seen->best = sample;
        seen->best_energy = energy;
    }
}

survey survey_samples(const answer *looked_at)
{
    survey seen = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    for (uint32_t sample = 0; sample < looked_at->samples.view.count; sample++) {
        look_at(looked_at, sample, &seen);
    }
    return seen;
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
                "sample %" PRIu32 " states the energy %s, but %s gives it %s (%" PRIu32 " of %" PRIu32
                " samples are wrong): "
                "whatever solved it did not solve this problem",
                seen->first_wrong, stated, looked_at->problem.name, found, seen->wrong, looked_at->samples.view.count);
}
