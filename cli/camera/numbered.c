#define _XOPEN_SOURCE 700

#include "camera/numbered.h"

#include <dirent.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"

enum { NUMBER_SIZE = 12 };

bool numbered_read(const char *path, numbered *read)
{
    const char *slash = strrchr(path, '/'), *base = slash != NULL ? slash + 1 : path;
    for (const char *at = strchr(base, '%'); at != NULL; at = strchr(at + 1, '%')) {
        bool padded = at[1] == '0' && at[2] >= '1' && at[2] <= '9';
        const char *letter = at + (padded ? 3 : 1);
        if (*letter == 'd') {
            *read = (numbered){path, (size_t)(at - path), letter + 1, padded ? at[2] - '0' : 1};
            return true;
        }
    }
    return false;
}

static void write_number(const numbered *of, uint32_t number, char text[NUMBER_SIZE])
{
    (void)snprintf(text, NUMBER_SIZE, "%0*" PRIu32, of->digits, number);
}

char *numbered_name(const numbered *of, uint32_t number, budget *limit)
{
    char text[NUMBER_SIZE];
    size_t size = of->before + strlen(of->after) + NUMBER_SIZE;
    char *name = budget_take(limit, of->pattern, size);
    if (name != NULL) {
        write_number(of, number, text);
        (void)snprintf(name, size, "%.*s%s%s", (int)of->before, of->pattern, text, of->after);
    }
    return name;
}

/* Reads the number of a file whose name, without its folder, fits the pattern from `begin` on. */
static bool read_number(const numbered *of, size_t begin, const char *name, uint32_t *number)
{
    size_t stem = of->before - begin, length = strlen(name), tail = strlen(of->after);
    char text[NUMBER_SIZE];
    if (length <= stem + tail || length - stem - tail >= NUMBER_SIZE - 1 ||
        memcmp(name, of->pattern + begin, stem) != 0 ||
        strcmp(name + length - tail, of->after) != 0) {
        return false;
    }
    size_t digits = length - stem - tail;
    uint64_t value = strtoull(name + stem, NULL, 10);
    *number = (uint32_t)value;
    write_number(of, *number, text);
    return value <= INT32_MAX && strlen(text) == digits && memcmp(text, name + stem, digits) == 0;
}

static DIR *open_folder(const numbered *of, size_t begin)
{
    char *folder = malloc(begin + 2);
    if (folder == NULL) {
        return NULL;
    }
    memcpy(folder, of->pattern, begin);
    memcpy(folder + begin, ".", 2);
    DIR *opened = opendir(folder);
    free(folder);
    return opened;
}

int numbered_find(const numbered *of, uint32_t from, uint32_t *number, bool *found)
{
    const char *slash = strrchr(of->pattern, '/');
    size_t begin = slash != NULL ? (size_t)(slash - of->pattern) + 1 : 0;
    DIR *folder = open_folder(of, begin);
    *found = false;
    if (folder == NULL) {
        return fail_system(of->pattern, "its folder cannot be read");
    }
    for (struct dirent *file; (file = readdir(folder)) != NULL;) {
        uint32_t seen;
        if (read_number(of, begin, file->d_name, &seen) && seen >= from &&
            (!*found || seen < *number)) {
            *number = seen;
            *found = true;
        }
    }
    (void)closedir(folder);
    return DONE;
}
