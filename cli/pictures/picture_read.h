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

/* Reads and decodes a picture; picture_free frees it. */
int picture_read(const char *path, picture *read);

/* The two halves of that: the bytes of the file, and the picture that they hold. `owner` becomes
 * the owner of the bytes: budget_free frees them, also after a failure. */
int picture_read_file(const char *path, budget *owner, file_bytes *file);
int picture_decode(const char *path, const file_bytes *file, picture *decoded);

/* Turns a picture_status into an exit status, and prints the reason of a failure. */
int picture_fail(const char *path, picture_status status, const char *reason);

#endif
