/* A labelling as what its labels stand for: a picture, a field of displacements. Each function
 * returns an exit status and has printed why it failed. */
#ifndef MEANINGS_H
#define MEANINGS_H

#include "fields/flow_file.h"
#include "pictures/picture.h"
#include "qstereo.h"

/* What the labels are called: "disparity", "class", ... */
const char *meaning_name(qs_meaning_kind kind);

/* A labelling of numbers, greys or classes as a picture of them, 0 where there is no site. `name`
 * is for messages. The budget owns the samples. Returns DONE, BAD_INPUT (the problem is no grid, or
 * a value is above 65535) or NO_RESOURCE. */
int meaning_picture(const char *name, const qs_labels *labels, const uint16_t *labelling,
                    budget *limit, picture *made);

/* The same picture, of greys or classes up to 255, as bytes. */
int meaning_image(const char *name, const qs_labels *labels, const uint16_t *labelling,
                  budget *limit, qs_image *made);

/* A labelling of displacements as a field of the picture's size. Returns DONE, BAD_INPUT or
 * NO_RESOURCE. */
int meaning_field(const char *name, const qs_labels *labels, const uint16_t *labelling,
                  budget *limit, flow_field *made);

#endif
