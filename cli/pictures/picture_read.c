#include "pictures/picture_read.h"

#include <stdlib.h>
#include <string.h>

#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "pictures/picture_size.h"
#include "text/fail.h"

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

/* What decoding takes beside the file: the picture library's samples of up to 16 bits, and ours;
 * our own few lines make the second alone. */
static uint64_t decoding_bytes(const file_bytes *file)
{
    picture stated;
    if (!picture_size(file, &stated)) {
        return 0;
    }
    return bytes_product(picture_bytes(&stated), pnm_is(file) ? 1 : 2);
}

/* Signed numbers and floats as grey: from 0 to white, which is 255 for floats and 65535 for whole
 * numbers. */
static int round_floats(const char *path, const float_picture *floats, picture *decoded)
{
    size_t count = floats->width * floats->height;
    float largest = 0;
    *decoded = (picture){floats->width, floats->height, 1, floats->whole ? 65535u : 255u, NULL};
    for (size_t i = 0; i < count; i++) {
        if (!(floats->values[i] >= 0 && floats->values[i] <= (float)decoded->maxval)) {
            return fail(BAD_INPUT, input_name(path),
                        "pixel (%zu, %zu) holds %g, but a grey picture has 0 to %lu: convert it to "
                        "8 or 16 bits",
                        i % floats->width, i / floats->width, (double)floats->values[i],
                        (unsigned long)decoded->maxval);
        }
        largest = floats->values[i] > largest ? floats->values[i] : largest;
    }
    if (!floats->whole && largest <= 1) {
        return fail(BAD_INPUT, input_name(path),
                    "holds floats up to 1, which may be white or nearly black: convert it to 8 or "
                    "16 bits");
    }
    if (!picture_allocate(decoded)) {
        return fail_memory(input_name(path));
    }
    for (size_t i = 0; i < count; i++) {
        decoded->samples[i] = (uint16_t)(floats->values[i] + 0.5F);
    }
    return DONE;
}

static int decode_signed(const char *path, const file_bytes *file, picture *decoded)
{
    float_picture floats = {.values = NULL};
    char reason[REASON_SIZE] = "";
    TRY(picture_fail(path, picture_library_decode_floats(file, &floats, reason), reason));
    int status = round_floats(path, &floats, decoded);
    free(floats.values);
    return status;
}

/* AVI, MP4 and its like, Matroska and WebM. */
static bool is_video(const file_bytes *file)
{
    static const struct {
        size_t at;
        const char *mark;
    } known[] = {
        {8, "AVI "}, {4, "ftypisom"}, {4, "ftypmp4"}, {4, "ftypqt"}, {0, "\x1a\x45\xdf\xa3"}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        size_t length = strlen(known[i].mark), end = known[i].at + length;
        if (file->size >= end && memcmp(file->bytes + known[i].at, known[i].mark, length) == 0) {
            return true;
        }
    }
    return false;
}

int picture_decode(const char *path, const file_bytes *file, const budget *limit, picture *decoded)
{
    char reason[REASON_SIZE] = "";
    if (file->size == 0) {
        return picture_fail(path, PICTURE_BAD, "is empty: a picture is needed here");
    }
    if (pfm_is(file)) {
        return picture_fail(path, PICTURE_BAD,
                            "is a PFM, which holds disparities: give a grey or colour picture");
    }
    if (is_video(file)) {
        return picture_fail(path, PICTURE_BAD,
                            "is a video: ffmpeg -i FILE -pix_fmt gray -f yuv4mpegpipe - makes a "
                            "stream of it, which match reads");
    }
    TRY(budget_need(limit, input_name(path), decoding_bytes(file)));
    if (picture_is_signed(file)) {
        return decode_signed(path, file, decoded);
    }
    picture_status status = pnm_is(file) ? pnm_decode(file, decoded, reason)
                                         : picture_library_decode(file, decoded, reason);
    bool tiled = status == PICTURE_BAD && picture_is_tiled(file);
    return picture_fail(path, status,
                        tiled ? "is a TIFF in tiles, which OpenCV cannot read here, or a damaged "
                                "one: write it in strips (tiffcp -s), or as a PNG"
                              : reason);
}

static int read_picture(const char *path, budget *work, picture *read)
{
    file_bytes file;
    TRY(file_read(path, work, &file));
    return picture_decode(path, &file, work, read);
}

/* Takes white as 2^bits - 1. Without `bits` warns of samples that may mean that. */
static int apply_bits(const char *path, unsigned bits, picture *read)
{
    const char *name = input_name(path);
    size_t count = read->width * read->height * read->channels;
    uint32_t white = bits > 0 ? (1u << bits) - 1 : read->maxval;
    uint16_t largest = 0;
    for (size_t i = 0; i < count; i++) {
        largest = read->samples[i] > largest ? read->samples[i] : largest;
    }
    if (bits > 0 && read->maxval != 65535) {
        return fail(BAD_INPUT, name, "says itself that white is %lu: leave out --bits",
                    (unsigned long)read->maxval);
    }
    if (largest > white) {
        return fail(BAD_INPUT, name, "has a sample of %u, which is more than --bits %u can hold",
                    (unsigned)largest, bits);
    }
    if (bits == 0 && read->maxval == 65535 && largest > 0 && largest < 4096) {
        warn(name,
             "is nearly black: the largest sample is %u of 65535. If it holds %d bits, add "
             "--bits %d",
             (unsigned)largest, largest < 1024 ? 10 : 12, largest < 1024 ? 10 : 12);
    }
    read->maxval = white;
    return DONE;
}

int picture_take_grey(const char *path, unsigned bits, budget *limit, picture *colour,
                      qs_image *grey)
{
    const char *name = input_name(path);
    uint64_t size = (uint64_t)colour->width * colour->height * colour->channels;
    uint8_t *pixels = NULL;
    *grey = (qs_image){NULL, colour->width, colour->height, colour->width};
    int status = budget_need(limit, name, bytes_sum(size, picture_bytes(colour)));
    status = status == DONE ? apply_bits(path, bits, colour) : status;
    if (status == DONE) {
        pixels = picture_grey(colour);
        grey->pixels = pixels;
        status = pixels != NULL ? budget_own(limit, name, pixels, (size_t)size) : fail_memory(name);
    }
    picture_free(colour);
    return status;
}

int picture_read_grey(const char *path, unsigned bits, budget *limit, qs_image *grey)
{
    picture colour;
    budget work = budget_inside(limit);
    int status = read_picture(path, &work, &colour);
    budget_free(&work);
    return status == DONE ? picture_take_grey(path, bits, limit, &colour, grey) : status;
}
