#define _DEFAULT_SOURCE /* madvise, beside all of POSIX */

#include "files.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "text/fail.h"
#include "text/numbers.h"
#include "text/options.h"

/* The regular files that were read: as many as a command line can name. A sequence may read more;
 * their names follow one pattern, so the first ones tell whether an output is one of them. */
static struct {
    dev_t device;
    ino_t inode;
} files_read[OPERANDS_MAX + GIVEN_MAX];
static size_t files_read_count;

/* A block of memory that a budget owns. */
struct taken {
    struct taken *next;
    void *memory;
    uint64_t size;
};

/* Large blocks that were freed, for the next one of the same size. */
enum { KEPT_MOST = 8, KEPT_LEAST = 1 << 20 };
static struct {
    void *memory;
    uint64_t size;
} kept[KEPT_MOST];
static size_t kept_count;
static bool keeping;

void budget_keep_blocks(void)
{
    keeping = true;
}

static void *take_kept(uint64_t size)
{
    for (size_t i = kept_count; i-- > 0;) {
        if (kept[i].size == size) {
            void *memory = kept[i].memory;
            kept[i] = kept[--kept_count];
            return memory;
        }
    }
    return NULL;
}

/* Frees kept blocks until they have no more than so many bytes together. */
static void drop_kept(uint64_t most)
{
    uint64_t all = 0;
    for (size_t i = 0; i < kept_count; i++) {
        all += kept[i].size;
    }
    while (all > most) {
        kept_count--;
        all -= kept[kept_count].size;
        free(kept[kept_count].memory);
    }
}

static void keep_or_free(const struct taken *block)
{
    if (!keeping || block->size < KEPT_LEAST || kept_count == KEPT_MOST) {
        free(block->memory);
        return;
    }
    kept[kept_count].memory = block->memory;
    kept[kept_count++].size = block->size;
}

budget budget_of(uint32_t mib)
{
    return (budget){(uint64_t)mib << 20, mib, NULL};
}

budget budget_inside(const budget *outer)
{
    return (budget){outer->left, outer->mib, NULL};
}

void budget_free(budget *freed)
{
    while (freed->taken != NULL) {
        struct taken *block = freed->taken;
        freed->taken = block->next;
        keep_or_free(block);
        free(block);
    }
}

int budget_read(const char *text, budget *limit)
{
    uint32_t mib;
    TRY(number_read("--memory-limit", text, 1, UINT32_MAX, &mib));
    *limit = budget_of(mib);
    return DONE;
}

/* Of a stream it is not known what it needs. */
static int fail_stream(const budget *limit, const char *place)
{
    return fail(NO_RESOURCE, place,
                "needs more than the memory limit of %lu MiB: raise --memory-limit",
                (unsigned long)limit->mib);
}

uint64_t bytes_sum(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

uint64_t bytes_product(uint64_t a, uint64_t b)
{
    return b != 0 && a > UINT64_MAX / b ? UINT64_MAX : a * b;
}

int budget_need(const budget *limit, const char *place, uint64_t size)
{
    if (size <= limit->left) {
        drop_kept(limit->left - size);
        return DONE;
    }
    uint64_t taken = ((uint64_t)limit->mib << 20) - limit->left;
    uint64_t all = bytes_sum(taken, size);
    uint64_t mib = (all >> 20) + (all % (1 << 20) != 0);
    return fail(NO_RESOURCE, place,
                "needs more than the memory limit of %lu MiB: raise --memory-limit to %" PRIu64,
                (unsigned long)limit->mib, mib);
}

/* Makes the budget the owner of memory from malloc. Frees it and returns false if there is none. */
static bool own(budget *limit, void *memory, uint64_t size)
{
    struct taken *block = memory != NULL ? malloc(sizeof *block) : NULL;
    if (block == NULL) {
        free(memory);
        return false;
    }
    *block = (struct taken){limit->taken, memory, size};
    limit->taken = block;
    limit->left -= size;
    return true;
}

/* Asks for large pages, of 2 MiB, where the system has them and they fit inside: solvers use all of
 * their memory, and each page that comes costs time. */
static void ask_for_large_pages(void *memory, size_t size)
{
#ifdef MADV_HUGEPAGE
    enum { LEAST = 1 << 23 };
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    size_t before = (page - (uintptr_t)memory % page) % page;
    if (memory != NULL && size >= LEAST) {
        /* Without large pages the memory is as good. */
        (void)madvise((char *)memory + before, (size - before) / page * page, MADV_HUGEPAGE);
    }
#else
    (void)memory;
    (void)size;
#endif
}

void *budget_take(budget *limit, const char *place, uint64_t size)
{
    if (budget_need(limit, place, size) != DONE) {
        return NULL;
    }
    void *memory = take_kept(size);
    if (memory == NULL && size <= SIZE_MAX) {
        memory = malloc(size > 0 ? (size_t)size : 1);
        if (memory == NULL && kept_count > 0) {
            drop_kept(0);
            memory = malloc(size > 0 ? (size_t)size : 1);
        }
        ask_for_large_pages(memory, (size_t)size);
    }
    if (!own(limit, memory, size)) {
        (void)fail_memory(place);
        return NULL;
    }
    return memory;
}

int budget_own(budget *limit, const char *place, void *memory, size_t size)
{
    int fits = budget_need(limit, place, size);
    if (fits != DONE) {
        free(memory);
        return fits;
    }
    return own(limit, memory, size) ? DONE : fail_memory(place);
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
    /* One byte more than the file's stated size, so that its end is seen without another
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
            return fail_stream(limit, name);
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

void file_remember(int descriptor)
{
    struct stat about;
    if (fstat(descriptor, &about) == 0 && S_ISREG(about.st_mode)) {
        remember_read(&about);
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

static int read_descriptor(int descriptor, const char *name, const budget *limit, file_bytes *file)
{
    struct stat about;
    size_t expected = 0;
    if (fstat(descriptor, &about) == 0 && S_ISREG(about.st_mode)) {
        TRY(budget_need(limit, name, (uint64_t)about.st_size));
        expected = (size_t)about.st_size;
        remember_read(&about);
    }
    return read_all(descriptor, name, expected, limit, file);
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
        return status;
    }
    return own(limit, file->bytes, file->size) ? DONE : fail_memory(name);
}

/* Maps a regular file that is not empty. Returns false for all others. */
static bool map_descriptor(int descriptor, file_bytes *file)
{
    struct stat about;
    if (fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode) || about.st_size <= 0 ||
        (uint64_t)about.st_size > SIZE_MAX) {
        return false;
    }
    void *bytes = mmap(NULL, (size_t)about.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (bytes == MAP_FAILED) {
        return false;
    }
    remember_read(&about);
    *file = (file_bytes){bytes, (size_t)about.st_size};
    return true;
}

int file_map(const char *path, budget *limit, file_bytes *file)
{
    if (strcmp(path, "-") == 0) {
        return file_read(path, limit, file);
    }
    int descriptor = open(path, O_RDONLY);
    if (descriptor < 0) {
        return fail_system(input_name(path), "cannot be opened");
    }
    bool mapped = map_descriptor(descriptor, file);
    (void)close(descriptor);
    return mapped ? DONE : file_read(path, limit, file);
}

void file_free(file_bytes *file)
{
    free(file->bytes);
    *file = (file_bytes){NULL, 0};
}

growing_file growing_begin(uint64_t left, uint64_t beside)
{
    return (growing_file){.file = {NULL, 0}, .most = left - beside, .beside = beside};
}

bool growing_append(void *grown, const void *bytes, size_t size)
{
    growing_file *to = grown;
    to->wanted += size;
    if (to->wanted > to->most) {
        to->over = true;
        return to->counts;
    }
    if (to->capacity - to->file.size < size) {
        size_t larger = (to->capacity + size) * 2;
        larger = larger > to->most ? (size_t)to->most : larger;
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
    if (grown->over || grown->refused) {
        file_free(&grown->file);
        TRY(budget_need(limit, place, bytes_sum(grown->beside, grown->wanted)));
        return fail_memory(place);
    }
    return budget_own(limit, place, grown->file.bytes, grown->file.size);
}
