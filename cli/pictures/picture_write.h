/* Writing pictures: PNG, PGM and PPM. Each function that can fail returns an exit status and has
 * printed why. */
#ifndef PICTURE_WRITE_H
#define PICTURE_WRITE_H

#include "output.h"
#include "pictures/picture.h"

/* Returns true if the name of a file ends like this, in letters of any case; `ending` has its
 * point: ".png". */
bool path_ends(const char *path, const char *ending);

/* The option -o of a command that writes a picture. */
#define PICTURE_OUTPUT_OPTION(NAME)                                                                \
    {"output", 'o',  true,                                                                         \
     NAME,     NULL, "picture to write: .png or .pgm; - is standard output, as PGM"}

/* Reads its argument. Returns DONE or BAD_USAGE. */
int picture_format_read(const char *path, bool *png);

/* Writes a picture to an open output. Returns DONE or NO_RESOURCE. */
int picture_write(const picture *written, bool png, output *to);

#endif
