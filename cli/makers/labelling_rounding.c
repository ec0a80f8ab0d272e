#include <stdio.h>

#include "makers/labelling_parts.h"
#include "text/fail.h"

/* Errors below this share of a unit are no loss: 0.1 is no 32-bit float either. */
static const double least_error = 1e-6;

/* The largest error, of costs where there is a site. */
static npy_rounding find_worst(const labelling_request *asked, const qs_problem *problem,
                               const npy_array *array, npy_scaling by)
{
    bool costs = array == &asked->costs;
    size_t piece = costs ? problem->labels : (size_t)array->count;
    npy_rounding worst = {0, 0};
    for (uint64_t from = 0; from < array->count; from += piece) {
        if (!costs || labelling_is_site(problem, from / piece)) {
            npy_rounding_find(array, from, piece, by, &worst);
        }
    }
    return worst;
}

void labelling_warn_rounding(const labelling_request *asked, const qs_problem *problem,
                             const npy_array *array, npy_scaling by, uint32_t units_in_one)
{
    char at[NPY_TEXT], unit[32] = "whole numbers";
    if (array->kind != NPY_FLOAT || asked->values[LABELLING_SCALE] != NULL) {
        return;
    }
    npy_rounding worst = find_worst(asked, problem, array, by);
    if (worst.most < least_error) {
        return;
    }
    if (units_in_one > 1) {
        (void)snprintf(unit, sizeof unit, "1/%lu", (unsigned long)units_in_one);
    }
    npy_index_write(array, worst.at, at);
    warn(array->name,
         "%s rounded to %s, by up to %.3g (at %s): --scale 1000 keeps three decimals, --scale 1 "
         "rounds without this warning",
         by.times == asked->scale ? "its floats are" : "lambda times its floats is", unit,
         worst.most / units_in_one, at);
}
