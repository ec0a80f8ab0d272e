/* Warnings of match about results that are hardly what was meant. They go to standard error and
 * change nothing else. */
#ifndef HINTS_H
#define HINTS_H

#include "pair.h"
#include "pictures/map_errors.h"

/* The right picture fits the left one far better when the two change places. */
void hint_swapped(const pair *of);

/* Many true disparities are beyond the range that was asked for. */
void hint_truth(const pair *of, const true_map *truth);

/* More than half of the pixels have the largest disparity. */
void hint_range(const pair *of, const pixel_map *map);

#endif
