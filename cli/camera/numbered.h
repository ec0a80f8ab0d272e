/* Files with a number in their name: left_%04d.png. */
#ifndef NUMBERED_H
#define NUMBERED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "files.h"

/* A name with one %d or %0Nd, N from 1 to 9, after its last slash. */
typedef struct numbered {
    const char *pattern; /* borrowed */
    size_t before; /* bytes before the % */
    const char *after; /* what follows the d */
    int digits; /* at least so many */
} numbered;

/* Returns false if a path is no such name. */
bool numbered_read(const char *path, numbered *read);

/* The name with a number in it, in memory of the budget; NULL, after a message, if there is
 * none. */
char *numbered_name(const numbered *of, uint32_t number, budget *limit);

/* Looks through the folder: the least number from `from` on that a file has. Returns DONE, with
 * *found, or NO_RESOURCE after a message. */
int numbered_find(const numbered *of, uint32_t from, uint32_t *number, bool *found);

#endif
