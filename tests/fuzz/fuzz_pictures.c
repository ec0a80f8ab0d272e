/* Pictures that qstereo reads by itself: PGM, PPM and PFM. */
#include <string.h>

#include "fuzz.h"
#include "pictures/netpbm.h"

static void read_samples(const file_bytes *file)
{
    picture read, again;
    char reason[REASON_SIZE] = "";
    picture_status status = pnm_decode(file, &read, reason);
    PROMISE(status != PICTURE_BAD || reason[0] != '\0');
    if (status != PICTURE_OK) {
        return;
    }
    uint8_t *grey = picture_grey(&read);
    size_t count = read.width * read.height * read.channels;
    file_bytes written = {NULL, 0};
    for (size_t i = 0; i < count; i++) {
        PROMISE(read.samples[i] <= read.maxval);
    }
    if (grey && pnm_encode(&read, &written) == PICTURE_OK) {
        PROMISE(pnm_decode(&written, &again, reason) == PICTURE_OK);
        PROMISE(again.width == read.width && again.height == read.height &&
                again.maxval == read.maxval &&
                memcmp(again.samples, read.samples, count * sizeof *read.samples) == 0);
        picture_free(&again);
    }
    file_free(&written);
    free(grey);
    picture_free(&read);
}

static void read_floats(const file_bytes *file)
{
    float_picture read, again;
    char reason[REASON_SIZE] = "";
    picture_status status = pfm_decode(file, &read, reason);
    PROMISE(status != PICTURE_BAD || reason[0] != '\0');
    file_bytes written = {NULL, 0};
    if (status == PICTURE_OK && pfm_encode(&read, &written) == PICTURE_OK) {
        PROMISE(pfm_decode(&written, &again, reason) == PICTURE_OK);
        PROMISE(again.width == read.width && again.height == read.height);
        free(again.values);
    }
    if (status == PICTURE_OK) {
        free(read.values);
    }
    file_free(&written);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    file_bytes file = {NULL, size};
    file.bytes = malloc(size + !size);
    memcpy(file.bytes, data, size);
    if (pnm_is(&file)) {
        read_samples(&file);
    }
    if (pfm_is(&file)) {
        read_floats(&file);
    }
    free(file.bytes);
    return 0;
}
