#include "arrays/units.h"

#include <inttypes.h>
#include <string.h>

#include "text/fail.h"

enum { PIECE = 4096 }; /* elements */

static int fail_element(const npy_array *array, uint64_t index, const units *as, npy_fault fault)
{
    char at[NPY_TEXT], value[NPY_TEXT];
    npy_index_write(array, index, at);
    npy_value_write(array, index, value);
    switch (fault) {
    case NPY_NAN:
        return fail(BAD_INPUT, array->name, "%s is %s, but %s is a number: put one there", at,
                    value, as->what);
    case NPY_INFINITE:
        return fail(BAD_INPUT, array->name,
                    "%s is %s, but %s has to be finite: put a finite number there", at, value,
                    as->what);
    case NPY_TOO_LARGE:
        if (strcmp(value, "-inf") == 0) {
            return fail(BAD_INPUT, array->name,
                        "%s is -inf: inf forbids a label, and no cost is below all others", at);
        }
        return fail(BAD_INPUT, array->name,
                    "%s is %s, too large (in the problem's units it is beyond 2147483647): %s", at,
                    value, as->mend);
    case NPY_FITS: break;
    }
    return fail(BAD_INPUT, array->name, "%s is %s: %s cannot be below 0", at, value, as->what);
}

int units_convert(const npy_array *array, const units *as, uint64_t from, size_t count,
                  int32_t *out)
{
    uint64_t bad = 0;
    npy_fault fault = npy_convert(array, from, count, as->by, as->infinite, out, &bad);
    if (fault != NPY_FITS) {
        return fail_element(array, bad, as, fault);
    }
    bool floats = array->kind == NPY_FLOAT; /* rounding may hide what is below 0 */
    for (size_t i = 0; !as->signed_too && i < count; i++) {
        if (floats ? npy_float(array, from + i) < 0 : out[i] < 0) {
            return fail_element(array, from + i, as, NPY_FITS);
        }
    }
    return DONE;
}

int units_check(const npy_array *array, const units *as)
{
    int32_t piece[PIECE];
    if (as->signed_too && npy_is_plain(array, as->by)) {
        return DONE;
    }
    for (uint64_t from = 0; from < array->count; from += PIECE) {
        uint64_t rest = array->count - from;
        TRY(units_convert(array, as, from, rest < PIECE ? (size_t)rest : PIECE, piece));
    }
    return DONE;
}

int units_read(const npy_array *array, const units *as, budget *limit, const int32_t **read)
{
    *read = npy_words(array, as->by);
    if (*read != NULL) {
        return units_check(array, as);
    }
    if (array->count > SIZE_MAX / sizeof(int32_t)) {
        return budget_fail(limit, array->name);
    }
    int32_t *values = budget_take(limit, array->name, (size_t)array->count * sizeof *values);
    if (values == NULL) {
        return NO_RESOURCE;
    }
    *read = values;
    return units_convert(array, as, 0, (size_t)array->count, values);
}
