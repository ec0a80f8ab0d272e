/* Reading pictures of any kind.
 *
 * The Netpbm formats are read and written by qstereo itself in every build, so that every build
 * makes the same bytes. All other formats are left to the picture library of the build
 * (picture_library.h). Each function returns an exit status: DONE, BAD_INPUT or NO_RESOURCE. It
 * has printed why it failed. */
#ifndef PICTURE_READ_H
#define PICTURE_READ_H

#include "files.h"
#include "pictures/picture.h"
#include "qstereo.h"

/* Decodes the bytes of a file, if the work fits the budget; picture_free frees the picture, which
 * is not taken from the budget. */
int picture_decode(const char *path, const file_bytes *file, const budget *limit, picture *decoded);

/* Reads a picture as grey, 8 bits a pixel, which the budget owns.
 *
 * bits  of a file of 16 bits: white is 2^bits - 1; 0 = it is what the file says */
int picture_read_grey(const char *path, unsigned bits, budget *limit, qs_image *grey);

/* The same of a picture that is there already; it is freed. */
int picture_take_grey(const char *path, unsigned bits, budget *limit, picture *colour,
                      qs_image *grey);

/* Turns a picture_status into an exit status, and prints the reason of a failure. */
int picture_fail(const char *path, picture_status status, const char *reason);

#endif
