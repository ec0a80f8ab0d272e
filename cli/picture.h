/* Pictures as files hold them, before they become grey pictures or maps.
 *
 * PGM, PPM and PFM are read and written by qstereo itself in every build, so that every build makes
 * the same bytes; all other formats are left to the picture library of the build
 * (picture_opencv.cpp), or to none (picture_none.c). */
#ifndef PICTURE_H
#define PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "files.h"

#ifdef __cplusplus
extern "C" {
#endif

/* height rows of width pixels of `channels` samples each, without gaps. An alpha channel is left
 * out. */
typedef struct picture {
    size_t width, height;
    unsigned channels; /* 1 grey, 3 RGB */
    uint32_t maxval; /* the sample of white, 1 .. 65535 */
    uint16_t *samples; /* from malloc */
} picture;

/* A picture of floats, rows from the top. */
typedef struct float_picture {
    size_t width, height;
    float *values; /* from malloc */
} float_picture;

typedef enum picture_status {
    PICTURE_OK,
    PICTURE_BAD, /* the reason says why */
    PICTURE_NO_MEMORY
} picture_status;

enum { REASON_SIZE = 240 };

/* Whole pictures of any kind (picture.c). Each returns DONE, BAD_INPUT or NO_RESOURCE, having said
 * why. */
int picture_read(const char *path, picture *read);
int picture_read_file(const char *path, file_bytes *file); /* its bytes only */
int picture_decode(const char *path, const file_bytes *file, picture *decoded);
int picture_fail(const char *path, picture_status status, const char *reason);

/* Allocates the samples; false = no memory. */
bool picture_allocate(picture *made);
void picture_free(picture *freed);

/* Brings the samples to 8 bits, then to grey: width * height bytes from malloc, NULL = no memory.
 */
uint8_t *picture_grey(const picture *colour);

/* PGM and PPM (picture_pnm.c). */
bool pnm_is(const file_bytes *file);
picture_status pnm_decode(const file_bytes *file, picture *decoded, char reason[REASON_SIZE]);
picture_status pnm_encode(const picture *encoded, file_bytes *file);

/* PFM of one value a pixel (picture_pfm.c). */
bool pfm_is(const file_bytes *file);
picture_status pfm_decode(const file_bytes *file, float_picture *decoded, char reason[REASON_SIZE]);
picture_status pfm_encode(const float_picture *encoded, file_bytes *file);

/* The picture library. */
const char *picture_library_name(void);
bool picture_library_writes_png(void);
picture_status picture_library_decode(const file_bytes *file, picture *decoded,
                                      char reason[REASON_SIZE]);
picture_status picture_library_encode_png(const picture *encoded, file_bytes *file);

#ifdef __cplusplus
}
#endif

#endif
