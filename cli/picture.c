#include "picture.h"

#include <stdlib.h>

#include "messages.h"

/* Over any picture that can be matched; so that a device without end does not fill the memory. */
enum { FILE_MIB_MAX = 1024 };

int picture_fail(const char *path, picture_status status, const char *reason)
{
    if (status == PICTURE_OK) {
        return DONE;
    }
    if (status == PICTURE_NO_MEMORY) {
        return fail_memory(input_name(path));
    }
    return fail(BAD_INPUT, input_name(path), "%s", reason);
}

bool picture_allocate(picture *made)
{
    made->samples = NULL;
    if (made->height <= SIZE_MAX / sizeof *made->samples / made->channels / made->width) {
        made->samples = malloc(made->width * made->height * made->channels * sizeof *made->samples);
    }
    return made->samples != NULL;
}

void picture_free(picture *freed)
{
    free(freed->samples);
    freed->samples = NULL;
}

int picture_read_file(const char *path, file_bytes *file)
{
    budget limit = {(uint64_t)FILE_MIB_MAX << 20, FILE_MIB_MAX};
    return file_read(path, &limit, file);
}

int picture_decode(const char *path, const file_bytes *file, picture *decoded)
{
    char reason[REASON_SIZE] = "";
    picture_status status = PICTURE_BAD;
    if (file->size == 0) {
        return picture_fail(path, status, "is empty, not a picture");
    }
    if (pfm_is(file)) {
        return picture_fail(
            path, status,
            "is a PFM, which holds disparities: a picture of grey or colours is needed here");
    }
    status = pnm_is(file) ? pnm_decode(file, decoded, reason)
                          : picture_library_decode(file, decoded, reason);
    return picture_fail(path, status, reason);
}

int picture_read(const char *path, picture *read)
{
    file_bytes file;
    int status = picture_read_file(path, &file);
    if (status != DONE) {
        return status;
    }
    status = picture_decode(path, &file, read);
    file_free(&file);
    return status;
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
