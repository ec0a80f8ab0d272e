#include <stdio.h>
#include <stdlib.h>

#include "picture.h"
#include "scanner.h"

bool pnm_is(const file_bytes *file)
{
    return file->size >= 2 && file->bytes[0] == 'P' && file->bytes[1] >= '1' &&
           file->bytes[1] <= '7';
}

static picture_status refuse(char reason[REASON_SIZE], const char *why)
{
    (void)snprintf(reason, REASON_SIZE, "is a damaged PGM or PPM: %s", why);
    return PICTURE_BAD;
}

/* Reads all before the samples, but not the blank in front of binary ones. */
static bool read_header(scanner *from, char kind, picture *decoded)
{
    uint32_t width, height;
    if (!scanner_number(from, &width) || !scanner_number(from, &height) ||
        !scanner_number(from, &decoded->maxval)) {
        return false;
    }
    decoded->width = width;
    decoded->height = height;
    decoded->channels = kind == '3' || kind == '6' ? 3 : 1;
    return width > 0 && height > 0 && decoded->maxval > 0 && decoded->maxval <= 65535;
}

/* Whether `bytes` can hold the samples, so that no header makes us allocate more than a small
 * multiple of the file. */
static bool fits(const picture *decoded, size_t bytes, size_t bytes_each)
{
    return decoded->height <= bytes / bytes_each / decoded->channels / decoded->width;
}

static picture_status read_ascii(scanner *from, picture *decoded, char reason[REASON_SIZE])
{
    uint32_t sample = 0;
    size_t count = decoded->width * decoded->height * decoded->channels;
    for (size_t i = 0; i < count; i++) {
        if (!scanner_number(from, &sample)) {
            return refuse(reason, scanner_at_end(from) ? "it ends before its last sample"
                                                       : "a sample is no number");
        }
        if (sample > decoded->maxval) {
            return refuse(reason, "a sample is above the greatest that its header states");
        }
        decoded->samples[i] = (uint16_t)sample;
    }
    return PICTURE_OK;
}

static picture_status read_binary(scanner *from, picture *decoded, char reason[REASON_SIZE])
{
    size_t count = decoded->width * decoded->height * decoded->channels;
    for (size_t i = 0; i < count; i++) {
        uint32_t sample = *from->at++;
        if (decoded->maxval > 255) {
            sample = sample << 8 | *from->at++;
        }
        if (sample > decoded->maxval) {
            return refuse(reason, "a sample is above the greatest that its header states");
        }
        decoded->samples[i] = (uint16_t)sample;
    }
    return PICTURE_OK;
}

static picture_status read_samples(scanner *from, bool binary, picture *decoded,
                                   char reason[REASON_SIZE])
{
    if (!picture_allocate(decoded)) {
        return PICTURE_NO_MEMORY;
    }
    picture_status status =
        binary ? read_binary(from, decoded, reason) : read_ascii(from, decoded, reason);
    if (status == PICTURE_OK && !scanner_at_end(from)) {
        status = refuse(reason, "something follows its last sample");
    }
    if (status != PICTURE_OK) {
        picture_free(decoded);
    }
    return status;
}

picture_status pnm_decode(const file_bytes *file, picture *decoded, char reason[REASON_SIZE])
{
    char kind = (char)file->bytes[1];
    bool binary = kind == '5' || kind == '6';
    scanner from = scanner_start(file);
    if (!binary && kind != '2' && kind != '3') {
        (void)snprintf(reason, REASON_SIZE,
                       "is a Netpbm file of kind P%c: PGM (P2, P5) and PPM (P3, P6) can be read",
                       kind);
        return PICTURE_BAD;
    }
    if (!read_header(&from, kind, decoded) || (binary && !scanner_one_blank(&from))) {
        return refuse(reason, "its header is not that of a picture of up to 16 bits");
    }
    /* In ASCII a sample takes a digit and a blank, the last one maybe none. */
    size_t left = (size_t)(from.end - from.at) + (binary ? 0 : 1);
    if (!fits(decoded, left, binary && decoded->maxval <= 255 ? 1 : 2)) {
        return refuse(reason, "it ends before its last sample");
    }
    return read_samples(&from, binary, decoded, reason);
}

picture_status pnm_encode(const picture *encoded, file_bytes *file)
{
    size_t count = encoded->width * encoded->height * encoded->channels;
    file->bytes = malloc(64 + 2 * count);
    if (file->bytes == NULL) {
        return PICTURE_NO_MEMORY;
    }
    int header =
        snprintf((char *)file->bytes, 64, "P%c\n%zu %zu\n%lu\n", encoded->channels == 3 ? '6' : '5',
                 encoded->width, encoded->height, (unsigned long)encoded->maxval);
    uint8_t *at = file->bytes + header;
    for (size_t i = 0; i < count; i++) {
        if (encoded->maxval > 255) {
            *at++ = (uint8_t)(encoded->samples[i] >> 8);
        }
        *at++ = (uint8_t)encoded->samples[i];
    }
    file->size = (size_t)(at - file->bytes);
    return PICTURE_OK;
}
