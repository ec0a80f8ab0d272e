#include "makers/labelling_parts.h"

#include "pictures/picture_write.h"
#include "pictures/planes.h"
#include "text/fail.h"

/* Numbers of an array as bytes, 0 or 1. */
static int read_mask_array(const char *path, budget *limit, qs_image *mask)
{
    npy_array array;
    TRY(npy_open(path, limit, &array));
    TRY(labelling_check_whole(&array, "a mask is whole numbers or logical values"));
    if (array.dimensions != 2 || array.count > QS_VARIABLES_MAX) {
        return labelling_fail_shape(&array, "a mask is H x W");
    }
    uint8_t *cells = budget_take(limit, array.name, (size_t)array.count);
    if (cells == NULL) {
        return NO_RESOURCE;
    }
    for (uint64_t i = 0; i < array.count; i++) {
        cells[i] = 0;
        for (unsigned b = 0; b < array.bytes; b++) {
            cells[i] |= array.data[i * array.bytes + b] != 0;
        }
    }
    *mask =
        (qs_image){cells, (size_t)array.shape[1], (size_t)array.shape[0], (size_t)array.shape[1]};
    return DONE;
}

int labelling_open_mask(const labelling_request *asked, budget *limit, qs_problem *problem)
{
    const char *path = asked->values[LABELLING_MASK];
    qs_image mask = {0};
    if (path == NULL) {
        return DONE;
    }
    size_t width = problem->grid.width, height = problem->grid.height;
    TRY(path_ends(path, ".npy") ? read_mask_array(path, limit, &mask)
                                : numbers_picture_read(path, limit, &mask));
    if (mask.width != width || mask.height != height) {
        return fail(BAD_INPUT, input_name(path),
                    "is %zu columns x %zu rows, but the costs are of %zu columns x %zu rows",
                    (size_t)mask.width, (size_t)mask.height, width, height);
    }
    problem->grid.mask = mask.pixels;
    if (qs_problem_sites(problem) == 0) {
        return fail(BAD_INPUT, input_name(path), "is 0 everywhere: no site is left");
    }
    return DONE;
}
