/* Whole files in memory, under a limit. */
#ifndef FILES_H
#define FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct file_bytes {
    uint8_t *bytes;
    size_t size;
} file_bytes;

/* The most that a command may hold, and what is left of it. */
typedef struct budget {
    uint64_t left;
    uint32_t mib;
} budget;

/* The argument of --memory-limit. Returns DONE or BAD_USAGE. */
int budget_read(const char *text, budget *limit);

/* Says that `place` does not fit. Returns NO_RESOURCE. */
int budget_fail(const budget *limit, const char *place);

/* Allocates `size` bytes from the budget. Returns DONE or NO_RESOURCE. */
int budget_allocate(budget *limit, const char *place, size_t size, void **memory);

/* Reads a file, "-" = standard input, that takes its size from the budget. Returns DONE or
 * NO_RESOURCE. */
int file_read(const char *path, budget *limit, file_bytes *file);

/* Whether a path leads to a regular file that file_read has read. */
bool file_was_read(const char *path);

void file_free(file_bytes *file);

/* A file that is being made in memory. */
typedef struct growing_file {
    file_bytes file;
    size_t capacity;
    uint64_t most; /* bytes that it may have */
    bool refused; /* there was no memory for some of it */
    bool over; /* or it would have been larger than that */
} growing_file;

/* Empty; `most` as above. */
growing_file growing_begin(uint64_t most);

/* Appends to a growing_file, as the library's sinks do. Returns false where there is no room. */
bool growing_append(void *grown, const void *bytes, size_t size);

/* Takes the size of a file that has been made from the budget. Returns DONE or NO_RESOURCE: there
 * was no room for all of it; then it is freed. */
int growing_end(growing_file *grown, const char *place, budget *limit);

#endif
