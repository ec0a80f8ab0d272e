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

int halves_make(const char *name, const qs_matching *of, const qs_pairwise *pairwise,
                const uint16_t *labelling, budget *limit, halves *made)
{
    qs_problem problem;
    qs_solution solution;
    TRY(make_problem(name, of, pairwise, limit, &problem));
    uint32_t sites = qs_problem_sites(&problem);
    size_t size = qs_near_workspace(&problem);
    void *workspace = budget_take(limit, name, size);
    made->labelling = budget_take(limit, name, sizeof *made->labelling * sites);
    if (workspace == NULL || made->labelling == NULL) {
        return NO_RESOURCE;
    }
    for (uint32_t i = 0; i < sites; i++) {
        made->labelling[i] = (uint16_t)(2 * labelling[i]);
    }
    qs_status status = qs_labels_of_problem(&problem, &made->labels);
    if (status == QS_OK) {
        status = qs_near(&problem, NULL, workspace, size, made->labelling, &solution);
    }
    return status == QS_OK ? DONE : fail_status(name, status);
}

uint64_t halves_bytes(const qs_problem *problem)
{
    enum { EACH = 32 }; /* costs, labels, what a line needs, and the weights of edges */
    return bytes_product(EACH, qs_problem_sites(problem));
}
