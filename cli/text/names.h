/* Names for the values of the library, as the command line, the tables and JSON have them, and the
 * known name that is nearest to a mistyped one. */
#ifndef NAMES_H
#define NAMES_H

#include <stdbool.h>
#include <stddef.h>

#include "qstereo.h"

typedef struct named {
    const char *name;
    int value;
} named;

typedef struct name_table {
    const char *what; /* the option that the names belong to: "encoding" */
    const named *names;
    size_t count;
    size_t typed; /* the command line takes the first `typed` names only */
} name_table;

extern const name_table smoothness_names;
extern const name_table penalty_names;
extern const name_table palette_names;
extern const name_table unit_names; /* of length; their values are millimetres */

/* The name of a value, NULL if it has none. */
const char *name_of(const name_table *table, int value);

/* Looks `text` up. Returns DONE, or BAD_USAGE after printing the known names and then `also`. */
int name_read(const name_table *table, const char *text, const char *also, int *value);

/* The names that the command line takes, one by one; NULL after the last. */
const char *name_at(const name_table *table, size_t index);

/* The same for encodings, whose names are the library's. */
const char *encoding_name(qs_encoding encoding);
int encoding_read(const char *text, qs_encoding *encoding);
const char *encoding_at(size_t index);

/* Writes the encodings for which `belongs` returns true as a list: "one-hot, domain-wall". */
enum { ENCODING_LIST_SIZE = 128 };
typedef bool encoding_belongs(qs_encoding encoding, const void *context);
void encodings_write(encoding_belongs *belongs, const void *context, char list[ENCODING_LIST_SIZE]);

/* Those that the solvers on this machine read. */
void encodings_with_model_write(char list[ENCODING_LIST_SIZE]);

/* Finds the name that a mistyped one was probably meant to be: suggest_for, then suggest_offer for
 * each known name. */
typedef struct suggestion {
    const char *typed;
    const char *nearest; /* of the names offered so far; NULL = none is near */
    size_t distance;
} suggestion;

suggestion suggest_for(const char *typed);
void suggest_offer(suggestion *suggested, const char *name);

#endif
