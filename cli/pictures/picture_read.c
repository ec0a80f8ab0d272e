#include "pictures/picture_read.h"

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
    TRY(budget_need(limit, input_name(path), decoding_bytes(file)));
    picture_status status = pnm_is(file) ? pnm_decode(file, decoded, reason)
                                         : picture_library_decode(file, decoded, reason);
    return picture_fail(path, status, reason);
}

static int read_picture(const char *path, budget *work, picture *read)
{
    file_bytes file;
    TRY(file_read(path, work, &file));
    return picture_decode(path, &file, work, read);
}

int picture_read_grey(const char *path, budget *limit, qs_image *grey)
{
    const char *name = input_name(path);
    picture colour;
    budget work = budget_inside(limit);
    int status = read_picture(path, &work, &colour);
    budget_free(&work);
    if (status != DONE) {
        return status;
    }
    uint64_t size = (uint64_t)colour.width * colour.height * colour.channels;
    uint8_t *pixels = NULL;
    *grey = (qs_image){NULL, colour.width, colour.height, colour.width};
    status = budget_need(limit, name, bytes_sum(size, picture_bytes(&colour)));
    if (status == DONE) {
        pixels = picture_grey(&colour);
        grey->pixels = pixels;
        status = pixels != NULL ? budget_own(limit, name, pixels, (size_t)size) : fail_memory(name);
    }
    picture_free(&colour);
    return status;
}
