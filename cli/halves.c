#include "halves.h"

#include "text/fail.h"

/* The same problem with half-pixel labels. All costs are doubled, so that half of a weight is a
 * whole number: two labels that are one pixel apart cost twice the weight, as they have to. */
static int make_problem(const char *name, const qs_matching *of, const qs_pairwise *pairwise,
                        budget *limit, qs_problem *problem)
{
    enum { PARTS = 2 };
    qs_matching finer = *of;
    qs_status status = QS_E_OVERFLOW;
    bool potts = pairwise->smoothness == QS_POTTS;
    bool fits = of->weight <= INT32_MAX / PARTS && of->scale <= INT32_MAX / PARTS &&
                pairwise->truncation <= QS_LABELS_MAX;
    made_problem made = {.name = name, .mend = "--lambda or --truncation"};
    finer.parts = PARTS;
    finer.copies = 0; /* lines are solved one after the other */
    finer.disparity_min *= PARTS;
    finer.disparity_max *= PARTS;
    if (fits) {
        finer.scale *= PARTS;
        finer.weight *= potts ? PARTS : 1;
        TRY(pair_problem(&finer, name, limit, problem, &status));
    }
    made.problem.scale = finer.scale;
    if (status != QS_OK) {
        return made_fail(&made, "choose a smaller --roi or --disparity, or --after without halves",
                         status);
    }
    problem->pairwise = *pairwise;
    problem->pairwise.truncation *= potts ? 1 : PARTS;
    return DONE;
}

int halves_begin(const char *name, const qs_matching *of, const qs_pairwise *pairwise,
                 budget *limit, halves *begun)
{
    begun->name = name;
    begun->made = QS_OK;
    TRY(make_problem(name, of, pairwise, limit, &begun->problem));
    qs_status status = qs_labels_of_problem(&begun->problem, &begun->labels);
    if (status != QS_OK) {
        return fail_status(name, status);
    }
    begun->labelling =
        budget_take(limit, name, sizeof *begun->labelling * qs_problem_sites(&begun->problem));
    return begun->labelling != NULL ? DONE : NO_RESOURCE;
}

size_t halves_workspace(const halves *begun)
{
    return qs_near_workspace(&begun->problem);
}

void halves_do(halves *begun, const uint16_t *labelling, void *workspace, size_t size)
{
    qs_solution solution;
    for (uint32_t i = 0, sites = qs_problem_sites(&begun->problem); i < sites; i++) {
        begun->labelling[i] = (uint16_t)(2 * labelling[i]);
    }
    begun->made = qs_near(&begun->problem, NULL, workspace, size, begun->labelling, &solution);
}

int halves_check(const halves *done)
{
    return done->made == QS_OK ? DONE : fail_status(done->name, done->made);
}

uint64_t halves_bytes(const qs_problem *problem)
{
    enum { EACH = 32 }; /* costs, labels, what a line needs, and the weights of edges */
    return bytes_product(EACH, qs_problem_sites(problem));
}
