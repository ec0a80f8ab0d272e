#include "survey.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "decimal.h"
#include "messages.h"

qs_status sample_labels(const qs_index *index, const uint8_t *bits, uint16_t *labelling,
                        int64_t *energy)
{
    qs_status status = qs_sample_decode(index, bits, labelling);
    if (status == QS_OK) {
        *energy = qs_qubo_energy(index, bits) + qs_sample_trimmed(index->qubo, labelling);
    }
    return status;
}

/* `labelling` is room for one, where costs were truncated. */
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

int survey_samples(const answer *looked_at, budget limit, survey *seen)
{
    const qs_qubo *qubo = &looked_at->problem.qubo;
    void *labelling = NULL;
    memset(seen, 0, sizeof *seen);
    if (qubo->has_labels && qubo->labels.trimmed_bytes > 0) {
        int status = budget_allocate(&limit, looked_at->problem.name,
                                     sizeof(uint16_t) * qubo->labels.sites, &labelling);
        if (status != DONE) {
            return status;
        }
    }
    for (uint32_t sample = 0; sample < looked_at->samples.view.count; sample++) {
        look_at(looked_at, sample, labelling, seen);
    }
    free(labelling);
    return DONE;
}

const char *feasible_means(const qs_qubo *qubo)
{
    switch (qubo->has_labels ? qubo->labels.encoding : QS_ENCODING_DEFAULT) {
    case QS_DOMAIN_WALL: return "in no site a 0 stands before a 1";
    case QS_MULTIWAY_CUT: return "each site has exactly one label, each terminal its own";
    case QS_ST_CUT:
    case QS_ST_CUT_ARCS: return "each site's chain falls from 1 to 0 once, source 1, sink 0";
    case QS_ENCODING_DEFAULT:
    case QS_ONE_HOT:
    case QS_ONE_HOT_SPARSE: break;
    }
    return "each site has exactly one label";
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
                "sample %" PRIu32 " states the energy %s, but %s gives it %s (%" PRIu32
                " of %" PRIu32 " samples are wrong): "
                "whatever solved it did not solve this problem",
                seen->first_wrong, stated, looked_at->problem.name, found, seen->wrong,
                looked_at->samples.view.count);
}
