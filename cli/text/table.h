/* A table for people, with columns as wide as their widest cell. */
#ifndef TABLE_H
#define TABLE_H

#include <stdbool.h>
#include <stddef.h>

enum { TABLE_CELL_SIZE = 256 };
typedef char table_cell[TABLE_CELL_SIZE];

/* Prints rows x columns cells. The first column is aligned to the left, the others to the right.
 * The last column is a note after them.
 *
 * hidden  for each column, true = it is left out; NULL = none is */
void table_print(table_cell *cells, size_t rows, size_t columns, const bool *hidden);

#endif
