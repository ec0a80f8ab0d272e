#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "arrays/little_endian.h"
#include "pictures/netpbm.h"
#include "pictures/scanner.h"

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
    return width > 0 && height > 0 && *end == '\0' && isfinite(unit) && unit != 0;
}

static float load_value(const uint8_t *bytes, bool little)
{
    const uint8_t turned[] = {bytes[3], bytes[2], bytes[1], bytes[0]};
    return load_float(little ? bytes : turned);
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
    if (decoded->height > (size_t)(from.end - from.at) / 4 / decoded->width) {
        return refuse_pfm(reason, "it ends before its last value");
    }
    size_t count = decoded->width * decoded->height;
    const char *wrong = scanner_samples(&from, count * 4, decoded->width * 4);
    if (wrong != NULL) {
        return refuse_pfm(reason, wrong);
    }
    decoded->values = malloc(count * sizeof *decoded->values);
    if (decoded->values == NULL) {
        return PICTURE_NO_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        decoded->values[upside_down(decoded, i)] = load_value(from.at + 4 * i, little);
    }
    return PICTURE_OK;
}

size_t pfm_header(size_t width, size_t height, uint8_t header[HEADER_SIZE])
{
    return (size_t)snprintf((char *)header, HEADER_SIZE, "Pf\n%zu %zu\n-1.0\n", width, height);
}

size_t pfm_pack(const float *values, size_t count, uint8_t *bytes)
{
    for (size_t i = 0; i < count; i++) {
        bytes = store_float(bytes, values[i]);
    }
    return 4 * count;
}

picture_status pfm_encode(const float_picture *encoded, file_bytes *file)
{
    file->bytes = malloc(HEADER_SIZE + 4 * encoded->width * encoded->height);
    if (file->bytes == NULL) {
        return PICTURE_NO_MEMORY;
    }
    file->size = pfm_header(encoded->width, encoded->height, file->bytes);
    for (size_t y = encoded->height; y-- > 0;) {
        file->size += pfm_pack(encoded->values + y * encoded->width, encoded->width,
                               file->bytes + file->size);
    }
    return PICTURE_OK;
}
