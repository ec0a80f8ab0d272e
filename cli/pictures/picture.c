#include "pictures/picture.h"

#include <stdlib.h>

#include "qstereo.h"

uint64_t picture_bytes(const picture *of)
{
    uint64_t row = (uint64_t)of->width * of->channels * sizeof *of->samples;
    return of->height <= UINT64_MAX / row ? row * of->height : UINT64_MAX;
}

bool picture_allocate(picture *made)
{
    uint64_t size = picture_bytes(made);
    made->samples = NULL;
    if (size <= SIZE_MAX) {
        made->samples = malloc((size_t)size);
    }
    return made->samples != NULL;
}

void picture_free(picture *freed)
{
    free(freed->samples);
    freed->samples = NULL;
}

static uint8_t to_8_bits(uint16_t sample, uint32_t maxval)
{
    return (uint8_t)(maxval == 255 ? sample : (sample * 255u + maxval / 2) / maxval);
}

uint8_t *picture_grey(const picture *colour)
{
    size_t row = colour->width * colour->channels;
    uint8_t *grey = malloc(row * colour->height);
    if (grey == NULL) {
        return NULL;
    }
    for (size_t i = 0; i < row * colour->height; i++) {
        grey[i] = to_8_bits(colour->samples[i], colour->maxval);
    }
    if (qs_image_grey(grey, colour->width, colour->height, row, colour->channels, grey) != QS_OK) {
        free(grey);
        return NULL;
    }
    return grey;
}
