#include "pictures/netpbm.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pictures/scanner.h"

/* How the samples of a file lie in it. */
typedef struct layout {
    bool binary;
    bool bits; /* of a PBM: 1 is black */
    unsigned channels; /* with the alpha that a PAM can have, which is left out */
} layout;

bool pnm_is(const file_bytes *file)
{
    return file->size >= 2 && file->bytes[0] == 'P' && file->bytes[1] >= '1' &&
           file->bytes[1] <= '7';
}

static picture_status refuse(char reason[REASON_SIZE], const char *why)
{
    (void)snprintf(reason, REASON_SIZE, "is a damaged PBM, PGM, PPM or PAM: %s", why);
    return PICTURE_BAD;
}

/* Reads the header of a PBM, PGM or PPM up to its last number. */
static bool read_numbers(scanner *from, char kind, picture *decoded, layout *lies)
{
    uint32_t width, height;
    *lies = (layout){kind >= '4', kind == '1' || kind == '4', kind == '3' || kind == '6' ? 3 : 1};
    decoded->maxval = 1;
    if (!scanner_number(from, &width) || !scanner_number(from, &height) ||
        (!lies->bits && !scanner_number(from, &decoded->maxval))) {
        return false;
    }
    decoded->width = width;
    decoded->height = height;
    decoded->channels = lies->channels;
    return true;
}

enum { PAM_WIDTH, PAM_HEIGHT, PAM_DEPTH, PAM_MAXVAL, PAM_NUMBERS };

/* Steps over the rest of a line of a PAM's header: its type, which the depth says too. */
static void skip_line(scanner *from)
{
    while (from->at < from->end && *from->at != '\n') {
        from->at++;
    }
}

/* Reads the header of a PAM up to ENDHDR. */
static bool read_pam(scanner *from, picture *decoded, layout *lies)
{
    static const char *const keys[PAM_NUMBERS] = {"WIDTH", "HEIGHT", "DEPTH", "MAXVAL"};
    uint32_t numbers[PAM_NUMBERS] = {0, 0, 0, 0};
    char word[16];
    while (scanner_word(from, word, sizeof word) && strcmp(word, "ENDHDR") != 0) {
        size_t key = 0;
        while (key < PAM_NUMBERS && strcmp(word, keys[key]) != 0) {
            key++;
        }
        if (key == PAM_NUMBERS && strcmp(word, "TUPLTYPE") == 0) {
            skip_line(from);
        } else if (key == PAM_NUMBERS || !scanner_number(from, &numbers[key])) {
            return false;
        }
    }
    decoded->width = numbers[PAM_WIDTH];
    decoded->height = numbers[PAM_HEIGHT];
    decoded->channels = numbers[PAM_DEPTH] < 3 ? 1 : 3;
    decoded->maxval = numbers[PAM_MAXVAL];
    *lies = (layout){true, false, numbers[PAM_DEPTH]};
    return strcmp(word, "ENDHDR") == 0 && lies->channels >= 1 && lies->channels <= 4;
}

static bool read_header(scanner *from, char kind, picture *decoded, layout *lies)
{
    bool read =
        kind == '7' ? read_pam(from, decoded, lies) : read_numbers(from, kind, decoded, lies);
    return read && decoded->width > 0 && decoded->height > 0 && decoded->maxval > 0 &&
           decoded->maxval <= 65535;
}

/* The bytes of a row of binary samples, or the fewest letters of a row of an ASCII file that has
 * one more at its end: a sample has at least a digit and a blank, but bits need no blanks. */
static uint64_t row_bytes(const picture *decoded, const layout *lies)
{
    uint64_t width = decoded->width;
    if (lies->bits) {
        return lies->binary ? (width + 7) / 8 : width;
    }
    return width * lies->channels * (lies->binary && decoded->maxval <= 255 ? 1 : 2);
}

/* Returns true if the file is long enough for the samples. So no header can make the command
 * allocate more than a small multiple of the file. */
static bool fits(const scanner *from, const picture *stated, const layout *lies)
{
    uint64_t left = (uint64_t)(from->end - from->at) + !lies->binary;
    return stated->height <= left / row_bytes(stated, lies);
}

static bool ascii_sample(scanner *from, const layout *lies, uint32_t *sample)
{
    if (!lies->bits) {
        return scanner_number(from, sample);
    }
    scanner_skip_blanks(from);
    if (from->at == from->end || (*from->at != '0' && *from->at != '1')) {
        return false;
    }
    *sample = *from->at++ == '0';
    return true;
}

static uint32_t binary_sample(scanner *from, const picture *decoded)
{
    uint32_t sample = *from->at++;
    return decoded->maxval > 255 ? sample << 8 | *from->at++ : sample;
}

static const char above[] = "a sample is above the largest value that the header allows";

/* Reads the samples. Returns NULL, or what is wrong. */
static const char *read_ascii(scanner *from, const layout *lies, picture *decoded)
{
    uint32_t sample = 0;
    size_t count = decoded->width * decoded->height * decoded->channels;
    for (size_t i = 0; i < count; i++) {
        if (!ascii_sample(from, lies, &sample)) {
            return scanner_at_end(from) ? "it ends before its last sample"
                                        : "a sample is not a number";
        }
        if (sample > decoded->maxval) {
            return above;
        }
        decoded->samples[i] = (uint16_t)sample;
    }
    return scanner_at_end(from) ? NULL : "something follows its last sample";
}

static const char *read_binary(scanner *from, const layout *lies, picture *decoded)
{
    uint16_t *to = decoded->samples;
    for (size_t i = 0; i < decoded->width * decoded->height; i++) {
        for (unsigned c = 0; c < lies->channels; c++) {
            uint32_t sample = binary_sample(from, decoded);
            if (sample > decoded->maxval) {
                return above;
            }
            if (c < decoded->channels) {
                *to++ = (uint16_t)sample;
            }
        }
    }
    return NULL;
}

/* The left pixel is the highest bit, and each row begins a byte. */
static void read_bits(const scanner *from, picture *decoded)
{
    size_t row = (decoded->width + 7) / 8;
    for (size_t y = 0; y < decoded->height; y++) {
        for (size_t x = 0; x < decoded->width; x++) {
            decoded->samples[y * decoded->width + x] =
                (from->at[y * row + x / 8] >> (7 - x % 8) & 1) == 0;
        }
    }
}

static const char *read_samples(scanner *from, const layout *lies, picture *decoded)
{
    if (!lies->binary) {
        return read_ascii(from, lies, decoded);
    }
    if (lies->bits) {
        read_bits(from, decoded);
        return NULL;
    }
    return read_binary(from, lies, decoded);
}

bool pnm_size(const file_bytes *file, picture *stated)
{
    scanner from = scanner_start(file);
    layout lies;
    return read_header(&from, (char)file->bytes[1], stated, &lies) && fits(&from, stated, &lies);
}

picture_status pnm_decode(const file_bytes *file, picture *decoded, char reason[REASON_SIZE])
{
    scanner from = scanner_start(file);
    layout lies;
    if (!read_header(&from, (char)file->bytes[1], decoded, &lies)) {
        return refuse(reason, "its header is not that of a picture of up to 16 bits");
    }
    if (!fits(&from, decoded, &lies)) {
        return refuse(reason, "it ends before its last sample");
    }
    size_t row = (size_t)row_bytes(decoded, &lies);
    const char *wrong = lies.binary ? scanner_samples(&from, decoded->height * row, row) : NULL;
    if (wrong != NULL) {
        return refuse(reason, wrong);
    }
    if (!picture_allocate(decoded)) {
        return PICTURE_NO_MEMORY;
    }
    wrong = read_samples(&from, &lies, decoded);
    if (wrong != NULL) {
        picture_free(decoded);
        return refuse(reason, wrong);
    }
    return PICTURE_OK;
}

size_t pnm_header(const picture *encoded, uint8_t header[HEADER_SIZE])
{
    return (size_t)snprintf((char *)header, HEADER_SIZE, "P%c\n%zu %zu\n%lu\n",
                            encoded->channels == 3 ? '6' : '5', encoded->width, encoded->height,
                            (unsigned long)encoded->maxval);
}

size_t pnm_pack(const uint16_t *samples, size_t count, uint32_t maxval, uint8_t *bytes)
{
    uint8_t *at = bytes;
    for (size_t i = 0; i < count; i++) {
        if (maxval > 255) {
            *at++ = (uint8_t)(samples[i] >> 8);
        }
        *at++ = (uint8_t)samples[i];
    }
    return (size_t)(at - bytes);
}

picture_status pnm_encode(const picture *encoded, file_bytes *file)
{
    size_t count = encoded->width * encoded->height * encoded->channels;
    file->bytes = malloc(HEADER_SIZE + 2 * count);
    if (file->bytes == NULL) {
        return PICTURE_NO_MEMORY;
    }
    file->size = pnm_header(encoded, file->bytes);
    file->size += pnm_pack(encoded->samples, count, encoded->maxval, file->bytes + file->size);
    return PICTURE_OK;
}
