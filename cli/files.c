#define _XOPEN_SOURCE 700

#include "files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "messages.h"
#include "numbers.h"
#include "options.h"

/* The regular files that were read: no command reads more than its command line has words for. */
static struct {
    dev_t device;
    ino_t inode;
} files_read[OPERANDS_MAX + GIVEN_MAX];
static size_t files_read_count;

int budget_read(const char *text, budget *limit)
{
    int status = number_read("--memory-limit", text, 1, UINT32_MAX, &limit->mib);
    limit->left = (uint64_t)limit->mib << 20;
    return status;
}

int budget_fail(const budget *limit, const char *place)
{
    return fail(NO_RESOURCE, place,
                "needs more than the memory limit of %lu MiB: raise --memory-limit",
                (unsigned long)limit->mib);
}

int budget_allocate(budget *limit, const char *place, size_t size, void **memory)
{
    if (size > limit->left) {
        return budget_fail(limit, place);
    }
    *memory = malloc(size > 0 ? size : 1);
    if (*memory == NULL) {
        return fail_memory(place);
    }
    limit->left -= size;
    return DONE;
}

/* Room for the next read, up to a byte over the limit. */
static bool make_room(file_bytes *file, size_t *capacity, uint64_t limit)
{
    if (file->size < *capacity) {
        return true;
    }
    size_t larger = *capacity + *capacity / 2;
    if (larger > limit) {
        larger = (size_t)limit + 1;
    }
    uint8_t *moved = larger > *capacity ? realloc(file->bytes, larger) : NULL;
    if (moved == NULL) {
        return false;
    }
    file->bytes = moved;
    *capacity = larger;
    return true;
}

static int read_all(int descriptor, const char *name, size_t expected, const budget *limit,
                    file_bytes *file)
{
    /* One byte over what the file says of itself, so that its end is seen without another
     * allocation. */
    size_t capacity = expected + 1 < 65536 ? 65536 : expected + 1;
    ssize_t got = 1;
    file->bytes = malloc(capacity);
    if (file->bytes == NULL) {
        return fail_memory(name);
    }
    while (got != 0) {
        if (!make_room(file, &capacity, limit->left)) {
            return fail_memory(name);
        }
        got = read(descriptor, file->bytes + file->size, capacity - file->size);
        if (got < 0) {
            return fail_system(name, "cannot be read");
        }
        file->size += (size_t)got;
        if (file->size > limit->left) {
            return budget_fail(limit, name);
        }
    }
    return DONE;
}

static void remember_read(const struct stat *about)
{
    if (files_read_count < sizeof files_read / sizeof files_read[0]) {
        files_read[files_read_count].device = about->st_dev;
        files_read[files_read_count++].inode = about->st_ino;
    }
}

bool file_was_read(const char *path)
{
    struct stat about;
    bool found = false;
    if (stat(path, &about) == 0) {
        for (size_t i = 0; i < files_read_count && !found; i++) {
            found = files_read[i].device == about.st_dev && files_read[i].inode == about.st_ino;
        }
    }
    return found;
}

static int read_descriptor(int descriptor, const char *name, budget *limit, file_bytes *file)
{
    struct stat about;
    size_t expected = 0;
    if (fstat(descriptor, &about) == 0 && S_ISREG(about.st_mode)) {
        if ((uint64_t)about.st_size > limit->left) {
            return budget_fail(limit, name);
        }
        expected = (size_t)about.st_size;
        remember_read(&about);
    }
    int status = read_all(descriptor, name, expected, limit, file);
    if (status == DONE) {
        limit->left -= file->size;
    }
    return status;
}

int file_read(const char *path, budget *limit, file_bytes *file)
{
    const char *name = input_name(path);
    bool standard = strcmp(path, "-") == 0;
    int descriptor = standard ? STDIN_FILENO : open(path, O_RDONLY);
    *file = (file_bytes){NULL, 0};
    if (descriptor < 0) {
        return fail_system(name, "cannot be opened");
    }
    int status = read_descriptor(descriptor, name, limit, file);
    if (!standard) {
        (void)close(descriptor);
    }
    if (status != DONE) {
        file_free(file);
    }
    return status;
}

void file_free(file_bytes *file)
{
    free(file->bytes);
    *file = (file_bytes){NULL, 0};
}

growing_file growing_begin(uint64_t most)
{
    return (growing_file){.file = {NULL, 0}, .most = most};
}

bool growing_append(void *grown, const void *bytes, size_t size)
{
    growing_file *to = grown;
    if (size > to->most - to->file.size) {
        to->over = true;
        return false;
    }
    if (to->capacity - to->file.size < size) {
        size_t larger = (to->capacity + size) * 2;
        uint8_t *moved = realloc(to->file.bytes, larger);
        if (moved == NULL) {
            to->refused = true;
            return false;
        }
        to->file.bytes = moved;
        to->capacity = larger;
    }
    memcpy(to->file.bytes + to->file.size, bytes, size);
    to->file.size += size;
    return true;
}

int growing_end(growing_file *grown, const char *place, budget *limit)
{
    int status = DONE;
    if (grown->over) {
        status = budget_fail(limit, place);
    } else if (grown->refused) {
        status = fail_memory(place);
    }
    if (status != DONE) {
        file_free(&grown->file);
        return status;
    }
    limit->left -= grown->file.size;
    return DONE;
}
