/* The window of the left picture that is to be matched, as the grid of a problem. */
#ifndef QS_WINDOW_H
#define QS_WINDOW_H

#include "../../include/qstereo/image.h"
#include "../../include/qstereo/problem.h"

/* Columns of the picture: those before `begin` and from `end` on are left out. */
typedef struct qs_columns {
    int64_t begin, end;
} qs_columns;

/* Fills in grid and frame of a problem: what the window and the columns have in common.
 * problem->frame.first stays.
 *
 * x .. height  the window; width 0 = the whole picture
 *
 * Returns QS_E_GEOMETRY if the sizes of the pictures differ, the window leaves the picture, or
 * nothing is left of it. */
static inline qs_status qs_window_place(const qs_image *left, const qs_image *right, uint32_t x,
                                        uint32_t y, uint32_t width, uint32_t height,
                                        qs_columns columns, qs_problem *problem)
{
    uint32_t across = (uint32_t)left->width, down = (uint32_t)left->height;
    if (width == 0) {
        x = y = 0;
        width = across;
        height = down;
    }
    if (right->width != across || right->height != down || x >= across || width > across - x ||
        y >= down || height > down - y || height == 0) {
        return QS_E_GEOMETRY;
    }
    int64_t begin = columns.begin > x ? columns.begin : x, end = (int64_t)x + width;
    end = end < columns.end ? end : columns.end;
    if (begin >= end) {
        return QS_E_GEOMETRY;
    }
    problem->grid = (qs_grid){.width = (uint32_t)(end - begin), .height = height};
    problem->frame = (qs_frame){across, down, (uint32_t)begin, y, problem->frame.first};
    return QS_OK;
}

#endif
