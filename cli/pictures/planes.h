/* Input pictures as the makers of problems want them: 8 bits a channel, in memory of the budget.
 * Each function returns DONE, BAD_INPUT or NO_RESOURCE, and has printed why. */
#ifndef PLANES_H
#define PLANES_H

#include "files.h"
#include "pictures/picture.h"
#include "qstereo.h"

/* A picture in colours or grey: height rows of width pixels of `channels` bytes, without gaps. */
typedef struct colours {
    uint8_t *pixels;
    uint32_t width, height;
    unsigned channels; /* 1 grey, 3 RGB */
} colours;

/* Reads and decodes a picture, which is not taken from the budget: picture_free frees it. */
int picture_open(const char *path, budget *limit, picture *read);

/* Reads a picture with the channels that it has, and a picture as grey. */
int colours_read(const char *path, budget *limit, colours *read);
int grey_read(const char *path, budget *limit, qs_image *read);

/* Reads a picture that is grey, of at most 8 bits, so that nothing of it is lost. One in colours,
 * or with more bits, is refused; R = G = B is grey. */
int plain_grey_read(const char *path, budget *limit, qs_image *read);

/* Reads a grey picture whose values are numbers, not brightness: strokes, masks, classes. They stay
 * as they are; none may be above 255. */
int numbers_picture_read(const char *path, budget *limit, qs_image *read);

/* Checks that two pictures have the same size. Returns DONE or BAD_INPUT. */
int same_size_check(const char *name, size_t width, size_t height, const char *as_name,
                    size_t as_width, size_t as_height);

#endif
