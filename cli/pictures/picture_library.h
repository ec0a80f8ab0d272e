/* The picture library that the command was built with: OpenCV (picture_opencv.cpp), or none
 * (picture_none.c). */
#ifndef PICTURE_LIBRARY_H
#define PICTURE_LIBRARY_H

#include "files.h"
#include "pictures/picture.h"

#ifdef __cplusplus
extern "C" {
#endif

/* For --version. */
const char *picture_library_name(void);

/* Returns true if the library writes PNG. */
bool picture_library_writes_png(void);

/* Decodes a picture that is no Netpbm file; picture_free frees it. */
picture_status picture_library_decode(const file_bytes *file, picture *decoded,
                                      char reason[REASON_SIZE]);

/* The same for a picture of signed numbers or floats, one a pixel. The caller frees the values. */
picture_status picture_library_decode_floats(const file_bytes *file, float_picture *decoded,
                                             char reason[REASON_SIZE]);

/* Encodes a PNG; file_free frees it. */
picture_status picture_library_encode_png(const picture *encoded, file_bytes *file);

#ifdef __cplusplus
}
#endif

#endif
