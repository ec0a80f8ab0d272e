/* How large a picture is, from the header of its file, before it is decoded. */
#ifndef PICTURE_SIZE_H
#define PICTURE_SIZE_H

#include "files.h"
#include "pictures/picture.h"

/* Reads width, height and channels (4 where it is not known, the most there are) of a Netpbm file,
 * PNG, JPEG, TIFF, BMP or WebP. Returns false if the file is none, or damaged. */
bool picture_size(const file_bytes *file, picture *stated);

/* Returns true for a TIFF in tiles. Some versions of OpenCV cannot read the small ones. */
bool picture_is_tiled(const file_bytes *file);

/* Returns true for a TIFF of signed numbers or of floats. */
bool picture_is_signed(const file_bytes *file);

#endif
