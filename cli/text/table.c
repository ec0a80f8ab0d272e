#include "text/table.h"

#include <stdio.h>
#include <string.h>

static size_t width_of(table_cell *cells, size_t rows, size_t columns, size_t column)
{
    size_t widest = 0;
    for (size_t row = 0; row < rows; row++) {
        size_t length = strlen(cells[row * columns + column]);
        widest = length > widest ? length : widest;
    }
    return widest;
}

void table_print(table_cell *cells, size_t rows, size_t columns, const bool *hidden)
{
    for (size_t row = 0; row < rows; row++) {
        table_cell *shown = &cells[row * columns];
        printf("%-*s", (int)width_of(cells, rows, columns, 0), shown[0]);
        for (size_t i = 1; i + 1 < columns; i++) {
            if (hidden == NULL || !hidden[i]) {
                printf("  %*s", (int)width_of(cells, rows, columns, i), shown[i]);
            }
        }
        const char *note = shown[columns - 1];
        printf("%s%s\n", note[0] != '\0' ? "  " : "", note);
    }
}
