#include "known_best.h"

#include "survey.h"
#include "text/fail.h"

int known_best_open(const problem_file *problem, budget *limit, known_best *known)
{
    const qs_qubo *qubo = &problem->qubo;
    *known = (known_best){NULL, 0, QS_NO_BOUND};
    if (qubo->known.bytes == 0) {
        return DONE;
    }
    uint8_t *bits = budget_take(limit, problem->name, ((size_t)qubo->variables + 7) / 8);
    uint16_t *labelling = budget_take(limit, problem->name, sizeof *labelling * qubo->labels.sites);
    if (bits == NULL || labelling == NULL) {
        return NO_RESOURCE;
    }
    qs_qubo_known_state(qubo, bits);
    qs_status status = sample_labels(&problem->index, bits, labelling, &known->energy);
    if (status != QS_OK) {
        return fail_status(problem->name, status);
    }
    known->labelling = labelling;
    known->lower_bound = qubo->known.lower_bound;
    return DONE;
}
