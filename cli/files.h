/* Memory under a limit, and whole files in it. */
#ifndef FILES_H
#define FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The memory that a command may hold (--memory-limit). It owns what was taken from it. */
typedef struct budget {
    uint64_t left; /* bytes */
    uint32_t mib; /* the whole limit, for messages */
    struct taken *taken; /* all of it, to be freed */
} budget;

/* A whole budget, and one that may take what another one has left. What is taken from the second
 * is not subtracted from the first: it is freed earlier. */
budget budget_of(uint32_t mib);
budget budget_inside(const budget *outer);

/* Frees everything that was taken from a budget. */
void budget_free(budget *freed);

/* From now on large blocks that are freed are kept for others of the same size, as far as the
 * budgets leave room for them. New memory costs time. */
void budget_keep_blocks(void);

/* Reads the argument of --memory-limit. Returns DONE or BAD_USAGE. */
int budget_read(const char *text, budget *limit);

/* Takes `size` bytes of memory; budget_free frees them. Returns NULL, after a message about
 * `place`, if they do not fit: then the exit status is NO_RESOURCE. */
void *budget_take(budget *limit, const char *place, uint64_t size);

/* Makes a budget the owner of memory from malloc. Returns DONE, or NO_RESOURCE, after a message, if
 * it does not fit; then the memory is freed. */
int budget_own(budget *limit, const char *place, void *memory, size_t size);

/* Looks whether `size` more bytes fit, before long work that needs them. Returns DONE, or
 * NO_RESOURCE after a message that says how much is needed. */
int budget_need(const budget *limit, const char *place, uint64_t size);

/* a + b and a * b, UINT64_MAX where they are more. */
uint64_t bytes_sum(uint64_t a, uint64_t b);
uint64_t bytes_product(uint64_t a, uint64_t b);

typedef struct file_bytes {
    uint8_t *bytes;
    size_t size;
} file_bytes;

/* Reads a file into memory that it takes from the budget; "-" is standard input. Returns DONE or
 * NO_RESOURCE. */
int file_read(const char *path, budget *limit, file_bytes *file);

/* The same, but a regular file is mapped: its bytes are read when they are looked at, and are not
 * the budget's. It stays mapped until the command ends. Nobody writes to them. */
int file_map(const char *path, budget *limit, file_bytes *file);

/* Remembers the file behind a descriptor as one that is read. */
void file_remember(int descriptor);

/* Returns true if a path leads to a regular file that is remembered, as each is that file_read or
 * file_map has read. */
bool file_was_read(const char *path);

/* Frees a file that no budget owns. */
void file_free(file_bytes *file);

/* A file that is being made in memory. */
typedef struct growing_file {
    file_bytes file;
    size_t capacity;
    uint64_t most; /* bytes that it may have */
    uint64_t beside; /* bytes that are in use only while it is made */
    uint64_t wanted; /* bytes appended, whether there was room or not */
    bool refused; /* there was no memory for some of it */
    bool over; /* it would have been larger than `most` */
    bool counts; /* if so, the rest is counted, so that growing_end can say what is needed */
} growing_file;

/* An empty file that may have what is left of a limit beside so many bytes. `beside` is at most
 * `left`. */
growing_file growing_begin(uint64_t left, uint64_t beside);

/* Appends to a growing_file, as a qs_sink does. Returns false if there is no room, and if it is
 * over, unless it counts. */
bool growing_append(void *grown, const void *bytes, size_t size);

/* Gives a finished file to the budget, which frees it. Returns DONE, or NO_RESOURCE after a
 * message, which says how much is needed, if there was no room for all of it. */
int growing_end(growing_file *grown, const char *place, budget *limit);

#endif
