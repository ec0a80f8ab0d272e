/* Matrices from the files of OpenCV's FileStorage, YAML or XML: those that a calibration of cameras
 * needs. Text that is no matrix, no list and no number is passed over. */
#ifndef STORAGE_H
#define STORAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "files.h"

enum { MATRIX_MAX = 16 };

typedef struct matrix {
    size_t rows, columns; /* a list has one row, a number is 1 x 1 */
    double values[MATRIX_MAX]; /* row after row */
} matrix;

/* A file that is being looked at; its bytes are borrowed. */
typedef struct storage {
    const char *text, *end;
    bool xml;
} storage;

storage storage_of(const file_bytes *file);

typedef enum stored_status {
    STORED,
    NOT_STORED,
    STORED_BADLY /* no matrix, or its sizes disagree, or a number cannot be read or is infinite */
} stored_status;

/* Finds the matrix, list or number with a name at the top of the file. It has at most MATRIX_MAX
 * values. */
stored_status storage_find(const storage *in, const char *name, matrix *found);

/* Reads numbers that stand between blanks, commas, semicolons and brackets, at most MATRIX_MAX.
 * Returns how many there are; MATRIX_MAX + 1 = too many, or one is no finite number. */
size_t storage_numbers(const char *text, const char *end, double values[MATRIX_MAX]);

#endif
