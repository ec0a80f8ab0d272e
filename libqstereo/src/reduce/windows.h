/* Better labellings of a grid, window by window. */
#ifndef QS_WINDOWS_H
#define QS_WINDOWS_H

#include "label_sets.h"
#include "rectangle.h"

/* Solves the windows of a grid one after the other, each with its neighbours held, and takes over
 * what is better. The windows are as large as `first` and stand side by side, the first one
 * first.x cells to the left of the grid's corner, and first.y above it.
 *
 * labelling  of kept labels; out: a better one
 * memory     aligned for any type; windows that it does not suffice for are left out
 * look       ends it early; NULL = nobody looks
 * Returns by how much the energy has fallen. */
int64_t qs_windows_improve(const qs_elimination *e, qs_rectangle first, uint16_t *labelling,
                           void *memory, size_t size, qs_look *look);

#endif
