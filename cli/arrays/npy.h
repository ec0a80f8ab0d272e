/* Arrays of numpy: .npy files, version 1 to 3, of integers or floats of 32 or 64 bits, in the byte
 * order of this machine, in C order. They are mapped into memory, not loaded. Each function that
 * returns an exit status has printed why it failed. */
#ifndef NPY_H
#define NPY_H

#include "files.h"

typedef enum npy_kind { NPY_SIGNED, NPY_UNSIGNED, NPY_FLOAT } npy_kind;

enum { NPY_DIMENSIONS = 4, NPY_TEXT = 96 };

typedef struct npy_array {
    const char *name; /* of the file, for messages */
    npy_kind kind;
    unsigned bytes; /* of an element: 1, 2, 4 or 8 */
    unsigned dimensions;
    uint64_t shape[NPY_DIMENSIONS];
    uint64_t count; /* of elements */
    const uint8_t *data; /* may be at any address */
} npy_array;

/* Opens an array. Returns DONE, BAD_INPUT or NO_RESOURCE. */
int npy_open(const char *path, budget *limit, npy_array *opened);

/* Writes "5 x 4 x 16", and "[1, 2, 3]" of an element. */
void npy_shape_write(const npy_array *array, char text[NPY_TEXT]);
void npy_index_write(const npy_array *array, uint64_t index, char text[NPY_TEXT]);

/* Writes the value of an element: "-3", "nan". */
void npy_value_write(const npy_array *array, uint64_t index, char text[NPY_TEXT]);

/* How numbers become whole units. Integers are multiplied by times x factor. Floats are multiplied
 * by times, rounded to the nearest whole number (of two the even one), and multiplied by factor. */
typedef struct npy_scaling {
    uint32_t times, factor;
} npy_scaling;

typedef enum npy_fault { NPY_FITS, NPY_NAN, NPY_INFINITE, NPY_TOO_LARGE } npy_fault;

/* Converts elements from `from` on. An infinite one becomes 0, and is passed over if `infinite` is
 * true.
 *
 * bad  out: the index of the first element that does not fit, in the array */
npy_fault npy_convert(const npy_array *array, uint64_t from, size_t count, npy_scaling by,
                      bool infinite, int32_t *out, uint64_t *bad);

/* The largest error that such rounding makes, in 1/times, and the element that has it. */
typedef struct npy_rounding {
    double most;
    uint64_t at;
} npy_rounding;

/* Looks at `count` floats from `from` on, and keeps the largest error. What is not finite has
 * none. */
void npy_rounding_find(const npy_array *array, uint64_t from, size_t count, npy_scaling by,
                       npy_rounding *worst);

/* Returns true if no element can have a fault: whole numbers of at most 32 bits that stay as they
 * are. */
bool npy_is_plain(const npy_array *array, npy_scaling by);

/* The elements themselves, if they are 32-bit integers that stay as they are; else NULL. */
const int32_t *npy_words(const npy_array *array, npy_scaling by);

/* An element of an array of floats. */
double npy_float(const npy_array *array, uint64_t index);

/* Returns true if an element is +infinity. */
bool npy_is_infinite(const npy_array *array, uint64_t index);

/* The head of a file of 32-bit integers, whose elements follow in C order. Its bytes are `text`;
 * returns their number. */
enum { NPY_HEAD = 128 };
size_t npy_head_write(const uint64_t *shape, unsigned dimensions, uint8_t head[NPY_HEAD]);

#endif
