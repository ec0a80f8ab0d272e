#include "arrays/npy.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"

#define MAGIC "\x93NUMPY"
enum { MAGIC_SIZE = 6, VERSION_AT = 6, LENGTH_AT = 8, HEADER_MOST = 1 << 16 };

/* ---- The header: {'descr': '<i4', 'fortran_order': False, 'shape': (5, 4), } ---- */

/* The text after a key; NULL = it is not there. */
static const char *value_of(const char *header, const char *key)
{
    char quoted[32];
    (void)snprintf(quoted, sizeof quoted, "'%s'", key);
    const char *at = strstr(header, quoted);
    if (at == NULL) {
        return NULL;
    }
    at += strlen(quoted);
    at += strspn(at, " ");
    if (*at++ != ':') {
        return NULL;
    }
    return at + strspn(at, " ");
}

static int fail_header(const npy_array *array)
{
    return fail(BAD_INPUT, array->name, "has a header that is not that of a .npy file");
}

/* The sign of numpy for the byte order of this machine. Arrays of others are refused. */
static char own_order(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, sizeof first);
    return first == 1 ? '<' : '>';
}

static int read_type(const char *header, npy_array *array)
{
    char type[8] = "";
    const char *at = value_of(header, "descr");
    if (at == NULL || *at != '\'' || sscanf(at + 1, "%7[^']", type) != 1) {
        return fail(BAD_INPUT, array->name,
                    "holds records or other elements: an array of integers or floats is needed");
    }
    char order = type[0], kind = type[1];
    unsigned long bytes = strtoul(type + 2, NULL, 10);
    bool wide = bytes == 4 || bytes == 8;
    bool integer = (kind == 'i' || kind == 'u') && (bytes == 1 || bytes == 2 || wide);
    bool logical = kind == 'b' && bytes == 1;
    if ((order != own_order() && order != '|') || !(integer || logical || (kind == 'f' && wide))) {
        return fail(BAD_INPUT, array->name,
                    "has elements of the type %s: save it as integers or floats of this machine, "
                    "array.astype('i4') or array.astype('f4')",
                    type);
    }
    array->bytes = (unsigned)bytes;
    array->kind = kind == 'i' ? NPY_SIGNED : kind == 'f' ? NPY_FLOAT : NPY_UNSIGNED;
    return DONE;
}

static int read_order(const char *header, const npy_array *array)
{
    const char *at = value_of(header, "fortran_order");
    if (at != NULL && strncmp(at, "True", 4) == 0) {
        return fail(BAD_INPUT, array->name,
                    "is in Fortran order: save numpy.ascontiguousarray(array)");
    }
    return at != NULL && strncmp(at, "False", 5) == 0 ? DONE : fail_header(array);
}

static int read_shape(const char *header, npy_array *array)
{
    const char *at = value_of(header, "shape");
    array->count = 1;
    if (at == NULL || *at++ != '(') {
        return fail_header(array);
    }
    for (at += strspn(at, " "); *at >= '0' && *at <= '9';) {
        char *end;
        uint64_t length = strtoull(at, &end, 10);
        if (array->dimensions == NPY_DIMENSIONS) {
            return fail(BAD_INPUT, array->name, "has more than %d dimensions", NPY_DIMENSIONS);
        }
        if (length > UINT64_MAX / 8 || (length > 0 && array->count > UINT64_MAX / 8 / length)) {
            return fail_header(array);
        }
        array->shape[array->dimensions++] = length;
        array->count *= length;
        at = end + strspn(end, ", ");
    }
    return *at == ')' ? DONE : fail_header(array);
}

/* The header's place and length. Returns false if there is none. */
static bool find_header(const file_bytes *file, size_t *at, size_t *length)
{
    const uint8_t *bytes = file->bytes;
    if (file->size < LENGTH_AT + 4 || memcmp(bytes, MAGIC, MAGIC_SIZE) != 0 ||
        bytes[VERSION_AT] < 1 || bytes[VERSION_AT] > 3) {
        return false;
    }
    bool narrow = bytes[VERSION_AT] == 1;
    *at = narrow ? LENGTH_AT + 2 : LENGTH_AT + 4;
    *length = bytes[LENGTH_AT] | (size_t)bytes[LENGTH_AT + 1] << 8;
    if (!narrow) {
        *length |= (size_t)bytes[LENGTH_AT + 2] << 16 | (size_t)bytes[LENGTH_AT + 3] << 24;
    }
    return *length < HEADER_MOST && *length <= file->size - *at;
}

static int read_header(const char *header, npy_array *array)
{
    TRY(read_type(header, array));
    TRY(read_order(header, array));
    return read_shape(header, array);
}

int npy_open(const char *path, budget *limit, npy_array *opened)
{
    file_bytes file;
    size_t at, length;
    memset(opened, 0, sizeof *opened);
    opened->name = input_name(path);
    TRY(file_map(path, limit, &file));
    if (!find_header(&file, &at, &length)) {
        return fail(BAD_INPUT, opened->name, "is not a .npy file: write it with numpy.save");
    }
    char *header = budget_take(limit, opened->name, length + 1);
    if (header == NULL) {
        return NO_RESOURCE;
    }
    memcpy(header, file.bytes + at, length);
    header[length] = '\0';
    TRY(read_header(header, opened));
    opened->data = file.bytes + at + length;
    if (opened->count != (file.size - at - length) / opened->bytes ||
        (file.size - at - length) % opened->bytes != 0) {
        char shape[NPY_TEXT];
        npy_shape_write(opened, shape);
        return fail(BAD_INPUT, opened->name,
                    "holds %zu bytes of elements, which are not those of %s: it is cut short or "
                    "damaged",
                    file.size - at - length, shape);
    }
    return DONE;
}

/* ---- Words for messages. ---- */

void npy_shape_write(const npy_array *array, char text[NPY_TEXT])
{
    size_t used = 0;
    (void)snprintf(text, NPY_TEXT, "a single number");
    for (unsigned i = 0; i < array->dimensions; i++) {
        used += (size_t)snprintf(text + used, NPY_TEXT - used, "%s%" PRIu64, i > 0 ? " x " : "",
                                 array->shape[i]);
    }
}

void npy_index_write(const npy_array *array, uint64_t index, char text[NPY_TEXT])
{
    uint64_t at[NPY_DIMENSIONS] = {0};
    size_t used = 1;
    for (unsigned i = array->dimensions; i-- > 0;) {
        at[i] = index % array->shape[i];
        index /= array->shape[i];
    }
    (void)snprintf(text, NPY_TEXT, "[");
    for (unsigned i = 0; i < array->dimensions; i++) {
        used +=
            (size_t)snprintf(text + used, NPY_TEXT - used, "%s%" PRIu64, i > 0 ? ", " : "", at[i]);
    }
    (void)snprintf(text + used, NPY_TEXT - used, "]");
}

/* ---- Elements. ---- */

double npy_float(const npy_array *array, uint64_t index)
{
    const uint8_t *from = array->data + array->bytes * index;
    float single;
    double value;
    if (array->bytes == 8) {
        memcpy(&value, from, sizeof value);
        return value;
    }
    memcpy(&single, from, sizeof single);
    return (double)single;
}

static uint64_t unsigned_at(const npy_array *array, uint64_t index)
{
    uint64_t value = 0;
    size_t high = own_order() == '<' ? 0 : sizeof value - array->bytes;
    memcpy((uint8_t *)&value + high, array->data + array->bytes * index, array->bytes);
    return value;
}

static int64_t signed_at(const npy_array *array, uint64_t index)
{
    unsigned bits = 8 * array->bytes;
    uint64_t value = unsigned_at(array, index), sign = (uint64_t)1 << (bits - 1);
    bool negative = (value & sign) != 0;
    uint64_t rest = value & (sign - 1);
    return negative ? -(int64_t)(sign - 1 - rest) - 1 : (int64_t)rest;
}

void npy_value_write(const npy_array *array, uint64_t index, char text[NPY_TEXT])
{
    switch (array->kind) {
    case NPY_FLOAT: (void)snprintf(text, NPY_TEXT, "%g", npy_float(array, index)); break;
    case NPY_UNSIGNED: (void)snprintf(text, NPY_TEXT, "%" PRIu64, unsigned_at(array, index)); break;
    case NPY_SIGNED: (void)snprintf(text, NPY_TEXT, "%" PRId64, signed_at(array, index)); break;
    }
}

bool npy_is_plain(const npy_array *array, npy_scaling by)
{
    bool whole = array->kind != NPY_FLOAT && by.times == 1 && by.factor == 1;
    return whole && (array->bytes < 4 || (array->bytes == 4 && array->kind == NPY_SIGNED));
}

bool npy_is_infinite(const npy_array *array, uint64_t index)
{
    return array->kind == NPY_FLOAT && isinf(npy_float(array, index)) &&
           npy_float(array, index) > 0;
}

const int32_t *npy_words(const npy_array *array, npy_scaling by)
{
    const void *data = array->data;
    bool aligned = (uintptr_t)data % sizeof(int32_t) == 0;
    return npy_is_plain(array, by) && array->bytes == 4 && aligned ? data : NULL;
}

static npy_fault convert_float(double value, npy_scaling by, int32_t *out)
{
    *out = 0;
    if (isnan(value)) {
        return NPY_NAN;
    }
    if (isinf(value)) {
        return value > 0 ? NPY_INFINITE : NPY_TOO_LARGE;
    }
    double whole = nearbyint(value * by.times) * by.factor;
    if (whole > INT32_MAX || whole < INT32_MIN) {
        return NPY_TOO_LARGE;
    }
    *out = (int32_t)whole;
    return NPY_FITS;
}

static npy_fault convert_integer(const npy_array *array, uint64_t index, npy_scaling by,
                                 int32_t *out)
{
    const int64_t times = (int64_t)by.times * by.factor,
                  most = times > 0 ? INT32_MAX / times : INT32_MAX;
    bool has_sign = array->kind == NPY_SIGNED;
    uint64_t size = has_sign ? 0 : unsigned_at(array, index);
    int64_t value = has_sign ? signed_at(array, index) : (int64_t)(size <= INT32_MAX ? size : 0);
    *out = 0;
    if (size > INT32_MAX || value > most || value < -most) {
        return NPY_TOO_LARGE;
    }
    *out = (int32_t)(value * times);
    return NPY_FITS;
}

/* ---- Many elements at once. The loops have no branches, so that the compiler makes vectors of
 * them: each gathers in the highest bit of `over` whether an element does not fit. ---- */

/* For each element of a type: `out[i] = made`, after `gather`. */
#define CONVERT(type, gather, made)                                                                \
    for (size_t i = 0; i < count; i++) {                                                           \
        type value;                                                                                \
        memcpy(&value, from + i * sizeof value, sizeof value);                                     \
        gather;                                                                                    \
        out[i] = (int32_t)(made);                                                                  \
    }

/* Copies plain elements. */
static void copy_plain(const npy_array *array, const uint8_t *from, size_t count, int32_t *out)
{
    bool has_sign = array->kind == NPY_SIGNED;
    if (array->bytes == 4) {
        memcpy(out, from, count * sizeof *out);
    } else if (array->bytes == 2 && has_sign) {
        CONVERT(int16_t, (void)0, value)
    } else if (array->bytes == 2) {
        CONVERT(uint16_t, (void)0, value)
    } else if (has_sign) {
        CONVERT(int8_t, (void)0, value)
    } else {
        CONVERT(uint8_t, (void)0, value)
    }
}

/* An integer fits if value + offset is at most `span`: one more is seen in the highest bit of
 * span - it, or of it. */
#define CONVERT_INTEGERS(type)                                                                     \
    CONVERT(type, over |= ((uint64_t)value + offset) | (span - ((uint64_t)value + offset)),        \
            (uint32_t)value * times)

/* Converts integers. Returns false if one has a fault. */
static bool convert_integers(const npy_array *array, const uint8_t *from, size_t count,
                             npy_scaling by, int32_t *out)
{
    const uint64_t wide = (uint64_t)by.times * by.factor, most = wide > 0 ? INT32_MAX / wide : 0;
    const bool has_sign = array->kind == NPY_SIGNED;
    const uint64_t offset = has_sign ? most : 0, span = offset + most;
    const uint32_t times = (uint32_t)wide;
    uint64_t over = 0;
    switch (array->bytes) {
    case 1:
        if (has_sign) {
            CONVERT_INTEGERS(int8_t)
        } else {
            CONVERT_INTEGERS(uint8_t)
        }
        break;
    case 2:
        if (has_sign) {
            CONVERT_INTEGERS(int16_t)
        } else {
            CONVERT_INTEGERS(uint16_t)
        }
        break;
    case 4:
        if (has_sign) {
            CONVERT_INTEGERS(int32_t)
        } else {
            CONVERT_INTEGERS(uint32_t)
        }
        break;
    default:
        if (has_sign) {
            CONVERT_INTEGERS(int64_t)
        } else {
            CONVERT_INTEGERS(uint64_t)
        }
    }
    return over >> 63 == 0;
}

/* 1.5 x 2^52: a sum with it has no bits below 1, and the whole number in its last 32 bits. */
static uint32_t rounded(double value)
{
    double shifted = value + 6755399441055744.0;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return (uint32_t)bits;
}

/* The bits of a float but its sign: a whole number that grows with the size. Of infinity and of NaN
 * they are larger than those of all numbers. */
static uint32_t size_single(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits & UINT32_MAX >> 1;
}

static uint64_t size_double(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits & UINT64_MAX >> 1;
}

/* Converts floats. Returns false if one has a fault, or may have one: it is near the largest. */
static bool convert_floats(const npy_array *array, const uint8_t *from, size_t count,
                           npy_scaling by, int32_t *out)
{
    const double times = by.times, most = 0.999 * (INT32_MAX / by.factor) / (times > 0 ? times : 1);
    if (array->bytes == 4) {
        const uint32_t limit = size_single((float)most);
        uint32_t over = 0;
        CONVERT(float, over |= limit - size_single(value),
                rounded((double)value * times) * by.factor)
        return over >> 31 == 0;
    }
    const uint64_t limit = size_double(most);
    uint64_t over = 0;
    CONVERT(double, over |= limit - size_double(value), rounded(value * times) * by.factor)
    return over >> 63 == 0;
}

npy_fault npy_convert(const npy_array *array, uint64_t from, size_t count, npy_scaling by,
                      bool infinite, int32_t *out, uint64_t *bad)
{
    const uint8_t *data = array->data + array->bytes * from;
    npy_fault first = NPY_FITS;
    if (npy_is_plain(array, by)) {
        copy_plain(array, data, count, out);
        return NPY_FITS;
    }
    if (array->kind == NPY_FLOAT ? convert_floats(array, data, count, by, out)
                                 : convert_integers(array, data, count, by, out)) {
        return NPY_FITS;
    }
    for (size_t i = 0; i < count; i++) {
        npy_fault fault = array->kind == NPY_FLOAT
                              ? convert_float(npy_float(array, from + i), by, &out[i])
                              : convert_integer(array, from + i, by, &out[i]);
        if (fault != NPY_FITS && first == NPY_FITS && !(infinite && fault == NPY_INFINITE)) {
            first = fault;
            *bad = from + i;
        }
    }
    return first;
}

void npy_rounding_find(const npy_array *array, uint64_t from, size_t count, npy_scaling by,
                       npy_rounding *worst)
{
    for (uint64_t i = from; i < from + count; i++) {
        double exact = npy_float(array, i) * by.times, error = fabs(exact - nearbyint(exact));
        if (error > worst->most) {
            *worst = (npy_rounding){error, i};
        }
    }
}

/* ---- Writing. ---- */

size_t npy_head_write(const uint64_t *shape, unsigned dimensions, uint8_t head[NPY_HEAD])
{
    char *text = (char *)head + LENGTH_AT + 2;
    size_t room = NPY_HEAD - LENGTH_AT - 2, used;
    memset(head, ' ', NPY_HEAD);
    memcpy(head, MAGIC "\x01\x00", LENGTH_AT);
    head[LENGTH_AT] = (uint8_t)room;
    head[LENGTH_AT + 1] = 0;
    used = (size_t)snprintf(text, room, "{'descr': '%ci4', 'fortran_order': False, 'shape': (",
                            own_order());
    for (unsigned i = 0; i < dimensions; i++) {
        used += (size_t)snprintf(text + used, room - used, "%" PRIu64 ", ", shape[i]);
    }
    used += (size_t)snprintf(text + used, room - used, "), }");
    text[used] = ' '; /* the end of the string */
    head[NPY_HEAD - 1] = '\n';
    return NPY_HEAD;
}
