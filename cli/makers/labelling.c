#include "makers/labelling_parts.h"

#include <string.h>

#include "smoothness.h"
#include "text/fail.h"
#include "text/numbers.h"

/* --scale and --lambda: the problem's units are so fine that floats rounded to 1/scale and lambda
 * are whole numbers of them. */
static int read_units(const char *const *values, labelling_request *asked)
{
    const char *text = values[LABELLING_SCALE] != NULL ? values[LABELLING_SCALE] : "1";
    uint32_t scale, denominator;
    int32_t numerator;
    TRY(number_read("--scale", text, 1, DECIMAL_DENOMINATOR_MAX, &scale));
    TRY(lambda_read(values[LABELLING_LAMBDA], DECIMAL_DENOMINATOR_MAX, &denominator, &numerator));
    asked->scale = scale;
    asked->whole_lambda = denominator == 1;
    uint64_t in_one = scale;
    while (in_one % denominator != 0) {
        in_one += scale;
    }
    uint64_t weight = (uint64_t)numerator * (in_one / denominator);
    if (in_one > INT32_MAX || weight > INT32_MAX) {
        return fail_usage("--scale %s and --lambda %s need units finer than 1/2147483647: choose "
                          "rounder numbers",
                          text, values[LABELLING_LAMBDA]);
    }
    asked->factor = (uint32_t)(in_one / scale);
    asked->weight = (int32_t)weight;
    return DONE;
}

/* V comes from one of --smoothness, --pairwise and --tables. */
static int read_pairwise(const char *const *values, labelling_request *asked)
{
    const char *name = values[LABELLING_SMOOTHNESS], *pairwise = values[LABELLING_PAIRWISE],
               *tables = values[LABELLING_TABLES];
    if ((name != NULL) + (pairwise != NULL) + (tables != NULL) > 1) {
        return fail_usage("--smoothness, --pairwise and --tables each say what neighbours cost: "
                          "give one of them");
    }
    if (values[LABELLING_TRUNCATION] != NULL && name == NULL) {
        return fail_usage("--truncation goes with --smoothness linear or quadratic");
    }
    asked->pairwise.smoothness = pairwise != NULL ? QS_TABLE : QS_TABLES;
    if (pairwise != NULL || tables != NULL) {
        return DONE;
    }
    return smoothness_read(name != NULL ? name : "potts", values[LABELLING_TRUNCATION],
                           &asked->pairwise);
}

static int labelling_read(const char *const *operands, const char *const *values, void *state)
{
    labelling_request *asked = state;
    memset(asked, 0, sizeof *asked);
    asked->costs_path = operands[0];
    asked->values = values;
    if (values[LABELLING_EDGES] != NULL && values[LABELLING_MASK] != NULL) {
        return fail_usage("--mask goes with grids, not with --edges: leave sites out of the arrays "
                          "instead");
    }
    TRY(read_pairwise(values, asked));
    return read_units(values, asked);
}

static int open_graph(labelling_request *asked, budget *limit, qs_problem *problem)
{
    TRY(labelling_open_pairwise(asked, limit, problem));
    if (problem->grid.width == 0) {
        return labelling_open_edges(asked, limit, problem);
    }
    TRY(labelling_open_mask(asked, limit, problem));
    TRY(labelling_open_grid_weights(asked, limit, problem));
    return labelling_open_grid_tables(asked, limit, problem);
}

static int labelling_open(void *state, budget *limit, made_problem *opened)
{
    labelling_request *asked = state;
    qs_problem *problem = &opened->problem;
    opened->name = input_name(asked->costs_path);
    opened->mend = "--scale, --lambda or --truncation";
    TRY(npy_open(asked->costs_path, limit, &asked->costs));
    *problem = (qs_problem){.scale = asked->scale * asked->factor,
                            .weight = asked->weight,
                            .pairwise = asked->pairwise,
                            .meaning = {.kind = QS_MEANS_NUMBER}};
    TRY(labelling_check_costs(asked, problem));
    TRY(open_graph(asked, limit, problem));
    TRY(labelling_open_costs(asked, limit, problem));
    qs_status status = qs_problem_check(problem);
    return status == QS_OK ? DONE : made_fail(opened, "choose fewer sites or labels", status);
}

const maker labelling_maker = {sizeof(labelling_request), labelling_read, labelling_open, NULL};
