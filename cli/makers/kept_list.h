/* Lists of which boxes to keep, as decode makes them of a problem that has no boxes any more: CSV,
 * a line box,keep, then a line for each box, counted from 1. The file of boxes that the problem was
 * made of goes with them. Each function that returns an exit status has printed why it failed. */
#ifndef KEPT_LIST_H
#define KEPT_LIST_H

#include "makers/boxes.h"

/* Writes the list of boxes that have label 1. */
void kept_list_write(const uint16_t *kept, uint32_t count, output *out);

/* Reads a list of the boxes of a file.
 *
 * kept  out: 1 or 0 of each box; the budget owns it. Returns DONE, BAD_INPUT or
 *       NO_RESOURCE */
int kept_list_read(const char *path, const box_file *of, budget *limit, uint16_t **kept);

/* Checks that a file of boxes has as many as a problem has sites. Returns DONE or
 * BAD_INPUT. */
int kept_boxes_check(const char *problem, uint32_t sites, const box_file *boxes);

/* The boxes that are kept, as a file of their own. Returns DONE or NO_RESOURCE. */
int kept_boxes_take(const box_file *all, const uint16_t *kept, budget *limit, box_file *taken);

#endif
