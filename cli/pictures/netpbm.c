#include "pictures/netpbm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The words of a header: separated by blanks, with comments from # to the end of the line. */
typedef struct scanner {
    const uint8_t *at, *end;
} scanner;

static bool is_blank(uint8_t c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static void skip_blanks(scanner *from)
{
    bool comment = false;
    for (; from->at < from->end; from->at++) {
        if (*from->at == '#') {
            comment = true;
        } else if (*from->at == '\n' || *from->at == '\r') {
            comment = false;
        } else if (!comment && !is_blank(*from->at)) {
            break;
        }
    }
}

/* Starts after the two letters that name the format. */
static scanner scanner_start(const file_bytes *file)
{
    return (scanner){file->bytes + 2, file->bytes + file->size};
}

/* Reads a word into `text`. */
static bool scanner_word(scanner *from, char *text, size_t size)
{
    size_t used = 0;
    skip_blanks(from);
    while (from->at < from->end && !is_blank(*from->at) && *from->at != '#') {
        if (used + 1 == size) {
            return false;
        }
        text[used++] = (char)*from->at++;
    }
    text[used] = '\0';
    return used > 0;
}

/* Reads a whole number up to 2^31 - 1 that a blank, a comment or the end follows. */
static bool scanner_number(scanner *from, uint32_t *number)
{
    char text[11];
    uint64_t value = 0;
    if (!scanner_word(from, text, sizeof text)) {
        return false;
    }
    for (const char *digit = text; *digit != '\0'; digit++) {
        if (*digit < '0' || *digit > '9') {
            return false;
        }
        value = value * 10 + (uint64_t)(*digit - '0');
    }
    *number = (uint32_t)value;
    return value <= INT32_MAX;
}

/* Steps over the one blank between a header and binary samples. */
static bool scanner_one_blank(scanner *from)
{
    return from->at < from->end && is_blank(*from->at++);
}

/* Steps over blanks and comments. Returns true if nothing else is left. */
static bool scanner_at_end(scanner *from)
{
    skip_blanks(from);
    return from->at == from->end;
}

bool pnm_is(const file_bytes *file)
{
    return file->size >= 2 && file->bytes[0] == 'P' && file->bytes[1] >= '1' &&
           file->bytes[1] <= '7';
}

static picture_status refuse_pnm(char reason[REASON_SIZE], const char *why)
{
    (void)snprintf(reason, REASON_SIZE, "is a damaged PGM or PPM: %s", why);
    return PICTURE_BAD;
}

/* Reads the header, but not the blank between it and binary samples. */
static bool read_pnm_header(scanner *from, char kind, picture *decoded)
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

/* Returns true if `bytes` can hold the samples. So no header can make the command allocate more
 * than a small multiple of the file. */
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
            return refuse_pnm(reason, scanner_at_end(from) ? "it ends before its last sample"
                                                           : "a sample is not a number");
        }
        if (sample > decoded->maxval) {
            return refuse_pnm(reason, "a sample is above the largest value that the header allows");
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
            return refuse_pnm(reason, "a sample is above the largest value that the header allows");
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
        status = refuse_pnm(reason, "there are bytes after its last sample");
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
                       "is a Netpbm file of kind P%c: give a PGM (P2, P5) or a PPM (P3, P6)", kind);
        return PICTURE_BAD;
    }
    if (!read_pnm_header(&from, kind, decoded) || (binary && !scanner_one_blank(&from))) {
        return refuse_pnm(reason, "its header is not that of a picture of up to 16 bits");
    }
    /* In ASCII a sample has at least a digit and a blank; the last one needs no blank. */
    size_t left = (size_t)(from.end - from.at) + (binary ? 0 : 1);
    if (!fits(decoded, left, binary && decoded->maxval <= 255 ? 1 : 2)) {
        return refuse_pnm(reason, "it ends before its last sample");
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

bool pfm_is(const file_bytes *file)
{
    return file->size >= 2 && file->bytes[0] == 'P' &&
           (file->bytes[1] == 'f' || file->bytes[1] == 'F');
}

static picture_status refuse_pfm(char reason[REASON_SIZE], const char *why)
{
    (void)snprintf(reason, REASON_SIZE, "is a PFM that cannot be read: %s", why);
    return PICTURE_BAD;
}

/* The sign of the scale in the header says the byte order. Its size is a unit, which is ignored,
 * because disparities are in pixels. */
static bool read_pfm_header(scanner *from, float_picture *decoded, bool *little)
{
    uint32_t width, height;
    char scale[32], *end;
    if (!scanner_number(from, &width) || !scanner_number(from, &height) ||
        !scanner_word(from, scale, sizeof scale)) {
        return false;
    }
    double unit = strtod(scale, &end);
    decoded->width = width;
    decoded->height = height;
    *little = unit < 0;
    return width > 0 && height > 0 && *end == '\0' && isfinite(unit) && unit != 0 &&
           scanner_one_blank(from);
}

static float load_float(const uint8_t *bytes, bool little)
{
    uint32_t bits = little ? bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                                 (uint32_t)bytes[3] << 24
                           : bytes[3] | (uint32_t)bytes[2] << 8 | (uint32_t)bytes[1] << 16 |
                                 (uint32_t)bytes[0] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void store_float(uint8_t *bytes, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (unsigned i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(bits >> 8 * i);
    }
}

/* The place of pixel i of the file, whose rows go from the bottom, if rows go from the top. */
static size_t upside_down(const float_picture *flipped, size_t i)
{
    return (flipped->height - 1 - i / flipped->width) * flipped->width + i % flipped->width;
}

picture_status pfm_decode(const file_bytes *file, float_picture *decoded, char reason[REASON_SIZE])
{
    scanner from = scanner_start(file);
    bool little;
    if (file->bytes[1] == 'F') {
        return refuse_pfm(reason, "it has three values per pixel, but a map has one");
    }
    if (!read_pfm_header(&from, decoded, &little)) {
        return refuse_pfm(reason, "its header is damaged");
    }
    size_t left = (size_t)(from.end - from.at);
    if (decoded->height > left / 4 / decoded->width) {
        return refuse_pfm(reason, "it ends before its last value");
    }
    size_t count = decoded->width * decoded->height;
    if (count * 4 != left) {
        return refuse_pfm(reason, "there are bytes after its last value");
    }
    decoded->values = malloc(count * sizeof *decoded->values);
    if (decoded->values == NULL) {
        return PICTURE_NO_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        decoded->values[upside_down(decoded, i)] = load_float(from.at + 4 * i, little);
    }
    return PICTURE_OK;
}

picture_status pfm_encode(const float_picture *encoded, file_bytes *file)
{
    size_t count = encoded->width * encoded->height;
    file->bytes = malloc(64 + 4 * count);
    if (file->bytes == NULL) {
        return PICTURE_NO_MEMORY;
    }
    int header =
        snprintf((char *)file->bytes, 64, "Pf\n%zu %zu\n-1.0\n", encoded->width, encoded->height);
    for (size_t i = 0; i < count; i++) {
        store_float(file->bytes + header + 4 * i, encoded->values[upside_down(encoded, i)]);
    }
    file->size = (size_t)header + 4 * count;
    return PICTURE_OK;
}
