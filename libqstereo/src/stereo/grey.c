#include "../../include/qstereo/image.h"

#include <string.h>

bool qs_image_is_valid(const qs_image *image)
{
    return image->pixels && image->width > 0 && image->height > 0 &&
           image->stride >= image->width && image->width <= INT32_MAX && image->height <= INT32_MAX;
}

static void grey_row(const uint8_t *colour, size_t width, unsigned channels, uint8_t *grey)
{
    for (size_t x = 0; x < width; x++) {
        const uint8_t *pixel = colour + x * channels;
        grey[x] = (uint8_t)((299u * pixel[0] + 587u * pixel[1] + 114u * pixel[2] + 500u) / 1000u);
    }
}

qs_status qs_image_grey(const uint8_t *colour, size_t width, size_t height, size_t stride,
                        unsigned channels, uint8_t *grey)
{
    if (!colour || !grey || (channels != 1 && channels != 3 && channels != 4) ||
        width > SIZE_MAX / channels || stride < width * channels) {
        return QS_E_ARGUMENT;
    }
    for (size_t y = 0; y < height; y++) {
        if (channels == 1) {
            memmove(grey + y * width, colour + y * stride, width);
        } else {
            grey_row(colour + y * stride, width, channels, grey + y * width);
        }
    }
    return QS_OK;
}
