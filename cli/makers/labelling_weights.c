#include "makers/labelling_parts.h"

#include <string.h>

#include "text/fail.h"

/* Weights are lambda times what the array holds. */
static units weight_units(const labelling_request *asked)
{
    return (units){
        {(uint32_t)asked->weight, 1}, "a weight", "choose a smaller --lambda", false, false};
}

/* Spreads rows of `columns` weights over a grid's width. */
static int read_grid_weights(const npy_array *array, const units *as, const qs_grid *grid,
                             uint32_t columns, budget *limit, const int32_t **weights)
{
    size_t width = grid->width, count = width * grid->height, rows = (size_t)array->shape[0];
    int32_t *spread = budget_take(limit, array->name, count * sizeof *spread);
    if (spread == NULL) {
        return NO_RESOURCE;
    }
    memset(spread, 0, count * sizeof *spread);
    *weights = spread;
    for (size_t y = 0; y < rows; y++) {
        TRY(units_convert(array, as, y * columns, columns, spread + y * width));
    }
    return DONE;
}

int labelling_open_grid_weights(const labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *text = asked->values[LABELLING_WEIGHTS];
    qs_grid *grid = &problem->grid;
    const units as = weight_units(asked);
    npy_array right, down;
    if (text == NULL) {
        return DONE;
    }
    const uint64_t of_right[] = {grid->height, grid->width - 1},
                   of_down[] = {grid->height - 1, grid->width};
    TRY(labelling_open_two("--weights", text, limit, &right, &down));
    TRY(labelling_check_shape(&right, "weights of edges to the right", of_right, 2));
    TRY(labelling_check_shape(&down, "weights of edges down", of_down, 2));
    TRY(read_grid_weights(&right, &as, grid, grid->width - 1, limit, &grid->right));
    TRY(read_grid_weights(&down, &as, grid, grid->width, limit, &grid->down));
    labelling_warn_rounding(asked, problem, &right, as.by, problem->scale);
    labelling_warn_rounding(asked, problem, &down, as.by, problem->scale);
    return DONE;
}

int labelling_open_edge_weights(const labelling_request *asked, const qs_problem *problem,
                                uint64_t count, budget *limit, const int32_t **weights)
{
    const units as = weight_units(asked);
    npy_array array;
    *weights = NULL;
    if (asked->values[LABELLING_WEIGHTS] == NULL) {
        return DONE;
    }
    TRY(labelling_open_one("--weights", asked->values[LABELLING_WEIGHTS], limit, &array));
    TRY(labelling_check_shape(&array, "weights of the edges", &count, 1));
    TRY(units_read(&array, &as, limit, weights));
    labelling_warn_rounding(asked, problem, &array, as.by, problem->scale);
    return DONE;
}
