/* Arrays as whole units, with a message for each number that is none: it names the array, the
 * index, the number and the mend. Each function returns DONE, BAD_INPUT or NO_RESOURCE. */
#ifndef UNITS_H
#define UNITS_H

#include "arrays/npy.h"

/* How an array is to be read. */
typedef struct units {
    npy_scaling by;
    const char *what; /* "a weight" */
    const char *mend; /* of numbers that are too large: "choose a smaller --lambda" */
    bool signed_too; /* numbers below 0 are allowed */
    bool infinite; /* +infinity is allowed, and becomes 0 */
} units;

/* Converts elements from `from` on. */
int units_convert(const npy_array *array, const units *as, uint64_t from, size_t count,
                  int32_t *out);

/* Converts a whole array into memory of the budget. One that is 32-bit integers already stays where
 * it is. */
int units_read(const npy_array *array, const units *as, budget *limit, const int32_t **read);

/* Checks all elements, a piece at a time. */
int units_check(const npy_array *array, const units *as);

#endif
