/* The names that the command line, the tables and JSON have for the library's values. */
#ifndef NAMES_H
#define NAMES_H

#include <stddef.h>

typedef struct named {
    const char *name;
    int value;
} named;

typedef struct name_table {
    const char *what; /* "encoding" */
    const named *names;
    size_t count;
    size_t typed; /* the first so many can be asked for on the command line */
} name_table;

extern const name_table encoding_names;
extern const name_table smoothness_names;
extern const name_table penalty_names;
extern const name_table cost_names;

/* NULL = the value has none. */
const char *name_of(const name_table *table, int value);

/* Looks `text` up. Returns DONE, or BAD_USAGE having listed the known names, then `also`. */
int name_read(const name_table *table, const char *text, const char *also, int *value);

#endif
