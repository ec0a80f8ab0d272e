/* Pictures as the library sees them: views of the caller's pixels. */
#ifndef QSTEREO_IMAGE_H
#define QSTEREO_IMAGE_H

#include <stdbool.h>

#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A grey picture of 8 bits a pixel. Pixel (x, y) is pixels[y * stride + x]. */
typedef struct qs_image {
    const uint8_t *pixels;
    size_t width, height;
    size_t stride; /* bytes from one row to the next, at least width */
} qs_image;

/* Returns true if a picture has pixels, a stride that holds them, and at most
 * 2^31 - 1 columns and rows. */
bool qs_image_is_valid(const qs_image *image);

/* Turns a colour picture of 8 bits a channel into a grey one:
 *
 *     (299 R + 587 G + 114 B + 500) / 1000
 *
 * in integers (luma of ITU-R BT.601, rounded), so that energies agree with
 * published ones on every machine.
 *
 * colour    rows of `width` pixels; a pixel is `channels` bytes, R first
 * stride    bytes from one row to the next
 * channels  1 (copied), 3 (RGB) or 4 (RGBA; the fourth is ignored)
 * grey      out: height rows of width bytes, without gaps; may be `colour`
 *
 * Returns
 *   QS_OK
 *   QS_E_ARGUMENT  a null pointer, another number of channels, or a stride
 *                  below width * channels */
QS_MUST_CHECK qs_status qs_image_grey(const uint8_t *colour, size_t width,
                                      size_t height, size_t stride,
                                      unsigned channels, uint8_t *grey);

#ifdef __cplusplus
}
#endif

#endif
