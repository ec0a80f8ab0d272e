/* A rectangle of the cells of a grid. */
#ifndef QS_RECTANGLE_H
#define QS_RECTANGLE_H

#include <stdint.h>

/* Cells x .. x + width - 1 of rows y .. y + height - 1. */
typedef struct qs_rectangle {
    uint32_t x, y, width, height;
} qs_rectangle;

#endif
