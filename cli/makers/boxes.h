/* Boxes of detections, as CSV: a line of names, then a line for each box. The columns picture, x,
 * y, width and height have to be there, score where it is needed; others are kept as they are. Each
 * function returns DONE, BAD_INPUT or NO_RESOURCE, and has printed why. */
#ifndef BOXES_H
#define BOXES_H

#include "files.h"
#include "output.h"
#include "qstereo.h"

/* The first line of a list that has only the numbers of boxes, which is no file of boxes:
 * kept_list.h. */
extern const char kept_list_head[];

/* A part of the text of a file. */
typedef struct slice {
    const char *text;
    size_t size;
} slice;

typedef struct box_file {
    const char *name;
    slice head; /* the line of names, without its end */
    uint32_t count;
    slice *lines; /* of each box */
    slice *pictures; /* what the column picture says */
    qs_box *boxes; /* in hundredths of a pixel; score 0 if there is none */
} box_file;

/* Reads a file. The numbers that boxes have for their pictures are places in `pictures`: the first
 * box of the same picture. All memory is the budget's.
 *
 * scored  the column score has to be there */
int boxes_read(const char *path, bool scored, budget *limit, box_file *read);

/* Writes the line of names and the lines of the boxes where kept[i] is 1. */
void boxes_write(const box_file *of, const uint16_t *kept, output *out);

/* How much two boxes overlap: the area of what they share over that of what they cover; of boxes of
 * two files the caller has to compare the pictures. */
double boxes_overlap(const qs_box *a, const qs_box *b);

#endif
