#include "pictures/picture_read.h"

#include "pictures/netpbm.h"
#include "pictures/picture_library.h"
#include "text/fail.h"

/* More than any picture that can be matched; a device without end does not fill the memory. */
enum { FILE_MIB_MAX = 1024 };

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

int picture_read_file(const char *path, budget *owner, file_bytes *file)
{
    *owner = budget_of(FILE_MIB_MAX);
    return file_read(path, owner, file);
}

int picture_decode(const char *path, const file_bytes *file, picture *decoded)
{
    char reason[REASON_SIZE] = "";
    if (file->size == 0) {
        return picture_fail(path, PICTURE_BAD, "is empty: a picture is needed here");
    }
    if (pfm_is(file)) {
        return picture_fail(path, PICTURE_BAD,
                            "is a PFM, which holds disparities: give a grey or colour picture");
    }
    picture_status status = pnm_is(file) ? pnm_decode(file, decoded, reason)
                                         : picture_library_decode(file, decoded, reason);
    return picture_fail(path, status, reason);
}

int picture_read(const char *path, picture *read)
{
    budget owner;
    file_bytes file;
    int status = picture_read_file(path, &owner, &file);
    if (status == DONE) {
        status = picture_decode(path, &file, read);
    }
    budget_free(&owner);
    return status;
}
