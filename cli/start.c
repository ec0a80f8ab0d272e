#include "start.h"

#include <inttypes.h>
#include <string.h>

#include "known_best.h"
#include "survey.h"
#include "text/fail.h"

/* Labels of the problem's sites become those of the model's, which has masked cells as well. They
 * move up, so the last one goes first. */
static void spread(const qs_model *model, uint32_t sites, uint16_t *labelling)
{
    for (uint32_t p = model->sites; model->mask != NULL && p-- > 0;) {
        bool masked = (model->mask[p / 8] >> p % 8 & 1) == 0;
        labelling[p] = masked ? 0 : labelling[--sites];
    }
}

/* The labelling that the problem's own file carries. */
static int start_from_file(job *at, const laid_out *problem, const uint16_t **start)
{
    known_best known;
    TRY(known_best_open(&at->both.problem, &at->limit, &known));
    if (known.labelling == NULL) {
        return DONE;
    }
    uint16_t *labelling =
        budget_take(&at->limit, problem->name, sizeof *labelling * problem->model.sites);
    if (labelling == NULL) {
        return NO_RESOURCE;
    }
    memcpy(labelling, known.labelling, sizeof *labelling * problem->labels.sites);
    spread(&problem->model, problem->labels.sites, labelling);
    *start = labelling;
    return DONE;
}

int start_read(job *at, const char *path, const laid_out *problem, const uint16_t **start)
{
    answer *both = &at->both;
    survey seen;
    *start = NULL;
    if (path == NULL) {
        return start_from_file(at, problem, start);
    }
    TRY(answer_open_samples(both, path, &at->limit));
    TRY(survey_samples(both, &at->limit, &seen));
    TRY(survey_fail_wrong(both, &seen));
    const char *name = both->samples.name;
    if (seen.feasible == 0) {
        return fail(BAD_INPUT, name,
                    "none of the %" PRIu32 " samples is a labelling, so there is nothing to begin "
                    "with: leave --start out",
                    both->samples.view.count);
    }
    uint16_t *labelling = budget_take(&at->limit, name, sizeof *labelling * problem->model.sites);
    if (labelling == NULL) {
        return NO_RESOURCE;
    }
    int64_t energy;
    qs_status status = sample_labels(
        &both->problem.index, qs_samples_bits(&both->samples.view, seen.best), labelling, &energy);
    if (status != QS_OK) {
        return fail_status(name, status);
    }
    spread(&problem->model, problem->labels.sites, labelling);
    *start = labelling;
    return DONE;
}
