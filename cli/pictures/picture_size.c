#include "pictures/picture_size.h"

#include <string.h>

#include "pictures/netpbm.h"

/* Bytes of a file, as numbers. Past the end there are zeros. */
typedef struct view {
    const file_bytes *file;
    bool big; /* the high byte first */
} view;

static uint32_t number_at(const view *of, uint64_t at, unsigned bytes)
{
    uint32_t number = 0;
    for (unsigned i = 0; i < bytes; i++) {
        uint64_t place = at + (of->big ? i : bytes - 1 - i);
        number = number << 8 | (place < of->file->size ? of->file->bytes[place] : 0u);
    }
    return number;
}

static bool begins_with(const file_bytes *file, const char *magic, size_t size)
{
    return file->size >= size && memcmp(file->bytes, magic, size) == 0;
}

/* ISO 15948: the chunk IHDR comes first. */
static void read_png(const file_bytes *file, picture *stated)
{
    const view of = {file, true};
    stated->width = number_at(&of, 16, 4);
    stated->height = number_at(&of, 20, 4);
}

/* ITU T.81: the size stands in the start of the frame, SOF. */
static void read_jpeg(const file_bytes *file, picture *stated)
{
    const view of = {file, true};
    uint64_t at = 2;
    while (at + 9 <= file->size && file->bytes[at] == 0xFF) {
        uint8_t marker = file->bytes[at + 1];
        if (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 &&
            marker != 0xCC) {
            stated->height = number_at(&of, at + 5, 2);
            stated->width = number_at(&of, at + 7, 2);
            return;
        }
        at += marker == 0xFF ? 1 : 2 + (uint64_t)number_at(&of, at + 2, 2);
    }
}

static bool is_tiff(const file_bytes *file)
{
    return begins_with(file, "II*\0", 4) || begins_with(file, "MM\0*", 4);
}

/* TIFF 6.0: a field of the first folder, `preset` if it is not there. */
static uint32_t tiff_field(const file_bytes *file, uint32_t tag, uint32_t preset)
{
    enum { SHORT = 3, FIELD_BYTES = 12 };
    const view of = {file, file->bytes[0] == 'M'};
    uint64_t folder = number_at(&of, 4, 4);
    uint32_t fields = number_at(&of, folder, 2);
    for (uint32_t i = 0; i < fields; i++) {
        uint64_t field = folder + 2 + FIELD_BYTES * (uint64_t)i;
        if (number_at(&of, field, 2) == tag) {
            return number_at(&of, field + 8, number_at(&of, field + 2, 2) == SHORT ? 2 : 4);
        }
    }
    return preset;
}

static void read_tiff(const file_bytes *file, picture *stated)
{
    enum { WIDTH = 256, HEIGHT = 257 };
    stated->width = tiff_field(file, WIDTH, 0);
    stated->height = tiff_field(file, HEIGHT, 0);
}

bool picture_is_tiled(const file_bytes *file)
{
    enum { TILE_WIDTH = 322 };
    return is_tiff(file) && tiff_field(file, TILE_WIDTH, 0) > 0;
}

bool picture_is_signed(const file_bytes *file)
{
    enum { SAMPLE_FORMAT = 339, UNSIGNED = 1, SIGNED = 2, FLOATS = 3 };
    uint32_t format = is_tiff(file) ? tiff_field(file, SAMPLE_FORMAT, UNSIGNED) : UNSIGNED;
    return format == SIGNED || format == FLOATS;
}

/* A negative height says that the rows go from the top. */
static void read_bmp(const file_bytes *file, picture *stated)
{
    const view of = {file, false};
    uint32_t height = number_at(&of, 22, 4);
    stated->width = number_at(&of, 18, 4);
    stated->height = height > INT32_MAX ? 0 - height : height;
}

/* RFC 9649: lossy, lossless or extended. */
static void read_webp(const file_bytes *file, picture *stated)
{
    const view of = {file, false};
    if (file->size > 15 && memcmp(file->bytes + 12, "VP8L", 4) == 0) {
        uint32_t bits = number_at(&of, 21, 4);
        stated->width = (bits & 0x3FFF) + 1;
        stated->height = (bits >> 14 & 0x3FFF) + 1;
    } else if (file->size > 15 && memcmp(file->bytes + 12, "VP8X", 4) == 0) {
        stated->width = number_at(&of, 24, 3) + 1;
        stated->height = number_at(&of, 27, 3) + 1;
    } else {
        stated->width = number_at(&of, 26, 2) & 0x3FFF;
        stated->height = number_at(&of, 28, 2) & 0x3FFF;
    }
}

bool picture_size(const file_bytes *file, picture *stated)
{
    *stated = (picture){.channels = 4};
    if (pnm_is(file)) {
        return pnm_size(file, stated);
    }
    if (begins_with(file, "\x89PNG", 4)) {
        read_png(file, stated);
    } else if (begins_with(file, "\xff\xd8", 2)) {
        read_jpeg(file, stated);
    } else if (is_tiff(file)) {
        read_tiff(file, stated);
    } else if (begins_with(file, "BM", 2)) {
        read_bmp(file, stated);
    } else if (begins_with(file, "RIFF", 4)) {
        read_webp(file, stated);
    }
    return stated->width > 0 && stated->height > 0;
}
