/* A table for people: each column as wide as what stands in it. */
#ifndef TABLE_H
#define TABLE_H

#include <stdbool.h>
#include <stddef.h>

enum { TABLE_CELL_SIZE = 256 };
typedef char table_cell[TABLE_CELL_SIZE];

/* Prints rows x columns cells. The first column stands at the left, the last one is a note behind
 * the others, those between stand at the right. hidden  columns that are left out; NULL = none. */
void table_print(table_cell *cells, size_t rows, size_t columns, const bool *hidden);

#endif
