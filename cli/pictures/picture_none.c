/* The picture library of a build without one. */
#include <stdio.h>
#include <string.h>

#include "pictures/picture_library.h"

const char *picture_library_name(void)
{
    return "PNM only";
}

bool picture_library_writes_png(void)
{
    return false;
}

static const char *known_format(const file_bytes *file)
{
    static const struct {
        const char *format, *start;
    } known[] = {{"a PNG", "\x89PNG"},
                 {"a JPEG", "\xff\xd8\xff"},
                 {"a TIFF", "II*"},
                 {"a TIFF", "MM"},
                 {"a BMP", "BM"}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        size_t length = strlen(known[i].start);
        if (file->size >= length && memcmp(file->bytes, known[i].start, length) == 0) {
            return known[i].format;
        }
    }
    return "not a picture that can be read here";
}

static picture_status refuse(const file_bytes *file, char reason[REASON_SIZE])
{
    (void)snprintf(reason, REASON_SIZE,
                   "is %s: this build reads PGM and PPM, PBM, PAM, and PFM maps. Convert it, or "
                   "build qstereo with "
                   "OpenCV (make OPENCV=1) for PNG, JPEG, TIFF, BMP and WebP",
                   known_format(file));
    return PICTURE_BAD;
}

picture_status picture_library_decode(const file_bytes *file, picture *decoded,
                                      char reason[REASON_SIZE])
{
    (void)decoded;
    return refuse(file, reason);
}

picture_status picture_library_decode_floats(const file_bytes *file, float_picture *decoded,
                                             char reason[REASON_SIZE])
{
    (void)decoded;
    return refuse(file, reason);
}

picture_status picture_library_encode_png(const picture *encoded, file_bytes *file)
{
    (void)encoded;
    (void)file;
    return PICTURE_BAD;
}
