/* A picture in memory, before it becomes a grey picture or a disparity map. */
#ifndef PICTURE_H
#define PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
    bool whole; /* they are whole numbers, as those of an integer type */
} float_picture;

/* What reading or writing a picture comes to. */
typedef enum picture_status {
    PICTURE_OK,
    PICTURE_BAD, /* the reason says why */
    PICTURE_NO_MEMORY
} picture_status;

enum { REASON_SIZE = 240 };

/* The bytes of all samples. */
uint64_t picture_bytes(const picture *of);

/* Allocates the samples. Returns false if there is no memory. */
bool picture_allocate(picture *made);
void picture_free(picture *freed);

/* The picture in grey, 8 bits a pixel: width * height bytes from malloc, NULL = no memory. */
uint8_t *picture_grey(const picture *colour);

#ifdef __cplusplus
}
#endif

#endif
