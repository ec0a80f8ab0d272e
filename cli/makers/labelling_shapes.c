#include "makers/labelling_parts.h"

#include <stdio.h>
#include <string.h>

#include "text/fail.h"

int labelling_fail_shape(const npy_array *array, const char *needed)
{
    char shape[NPY_TEXT];
    npy_shape_write(array, shape);
    return fail(BAD_INPUT, array->name, "has the shape %s, but %s", shape, needed);
}

int labelling_check_shape(const npy_array *array, const char *what, const uint64_t *shape,
                          unsigned dimensions)
{
    char needed[2 * NPY_TEXT], wanted[NPY_TEXT];
    npy_array like = {.dimensions = dimensions};
    memcpy(like.shape, shape, sizeof *shape * dimensions);
    if (array->dimensions == dimensions &&
        memcmp(array->shape, shape, sizeof *shape * dimensions) == 0) {
        return DONE;
    }
    npy_shape_write(&like, wanted);
    (void)snprintf(needed, sizeof needed, "%s must be %s with these costs", what, wanted);
    return labelling_fail_shape(array, needed);
}

int labelling_open_two(const char *option, const char *text, budget *limit, npy_array *right,
                       npy_array *down)
{
    const char *comma = strchr(text, ',');
    size_t length = strlen(text) + 1;
    if (comma == NULL || comma == text || comma[1] == '\0' || strchr(comma + 1, ',') != NULL) {
        return fail_usage("%s %s is not RIGHT.npy,DOWN.npy, the names of two arrays", option, text);
    }
    char *names = budget_take(limit, NULL, length);
    if (names == NULL) {
        return NO_RESOURCE;
    }
    memcpy(names, text, length);
    names[comma - text] = '\0';
    TRY(npy_open(names, limit, right));
    return npy_open(names + (comma - text) + 1, limit, down);
}

int labelling_open_one(const char *option, const char *text, budget *limit, npy_array *opened)
{
    return strchr(text, ',') == NULL
               ? npy_open(text, limit, opened)
               : fail_usage("%s %s: with --edges it is one array", option, text);
}

int labelling_check_whole(const npy_array *array, const char *needed)
{
    return array->kind != NPY_FLOAT ? DONE
                                    : fail(BAD_INPUT, array->name,
                                           "holds floats, but %s: save array.astype('i4')", needed);
}

const char *labelling_mend(const labelling_request *asked)
{
    if (asked->scale > 1) {
        return "choose a smaller --scale";
    }
    return asked->factor > 1 ? "choose a --lambda with fewer decimals" : "divide the array";
}
