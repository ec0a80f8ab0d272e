#include "pictures/picture_write.h"

#include <string.h>

#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "pictures/picture_read.h"
#include "text/fail.h"

bool path_ends(const char *path, const char *ending)
{
    size_t length = strlen(path), tail = strlen(ending);
    if (length < tail) {
        return false;
    }
    for (size_t i = 0; i < tail; i++) {
        if ((path[length - tail + i] | 0x20) != (ending[i] | 0x20)) {
            return false;
        }
    }
    return true;
}

/* The bytes of a picture, which file_free frees. */
static int picture_encode(const picture *encoded, bool png, const char *path, file_bytes *file)
{
    picture_status status =
        png ? picture_library_encode_png(encoded, file) : pnm_encode(encoded, file);
    return picture_fail(path, status, "cannot be made");
}

int picture_format_read(const char *path, bool *png)
{
    *png = path_ends(path, ".png");
    if (*png && !picture_library_writes_png()) {
        return fail_usage("%s: this build writes only .pgm; for .png build qstereo with OpenCV "
                          "(make OPENCV=1)",
                          path);
    }
    if (!*png && !output_is_straight(path) && !path_ends(path, ".pgm")) {
        return fail_usage("%s: the name of a picture ends in .png or .pgm", path);
    }
    return DONE;
}

int picture_write(const picture *written, bool png, output *to)
{
    file_bytes file = {NULL, 0};
    TRY(picture_encode(written, png, to->name, &file));
    output_write_file(to, &file);
    file_free(&file);
    return DONE;
}
