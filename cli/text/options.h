/* The command line of one command: a table that the parser, --help and the completion of shells are
 * made from. */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct option {
    const char *name; /* without its dashes */
    char letter; /* the short form; 0 = none */
    bool required;
    const char *argument; /* what its argument is called; NULL = a flag */
    const char *preset; /* the argument if the option is not given; NULL = none */
    const char *help;
    bool twice; /* it takes two arguments, one after the other: "LEFT RIGHT" */
    const char *needs; /* an option without which it says nothing; where a command has none of that
                          name, it stands alone. NULL = none */
} option;

/* Rows that commands share. */
#define JSON_OPTION {"json", 0, false, NULL, NULL, "print one JSON object"}
#define MEMORY_LIMIT_OPTION                                                                        \
    {"memory-limit", 0, false, "MIB", "4096", "the most memory for files and the work on them"}

enum { OPERANDS_MAX = 4, OPTIONS_MAX = 48, GIVEN_MAX = 256 };

typedef struct command_line {
    const char *name;
    const char *operands[OPERANDS_MAX]; /* what they are called */
    size_t optional; /* the last so many operands may be left out */
    const char *about; /* paragraphs, each ended by a newline; --help breaks their lines */
    const option *options;
    size_t option_count;
    const char *examples; /* whole lines */
} command_line;

typedef struct arguments {
    const char *operands[OPERANDS_MAX]; /* NULL = not given */
    /* By index in the table: the last argument given, else the preset; of a flag NULL or "". Of an
     * option with two arguments the second one. */
    const char *values[OPTIONS_MAX];
    /* Every option given, in order. */
    struct {
        size_t index;
        const char *value;
    } given[GIVEN_MAX];
    size_t given_count;
} arguments;

/* Reads the arguments, or answers --help. Returns true if the command is to go on; else *status is
 * its exit status. */
bool options_read(const command_line *line, int argc, char **argv, arguments *read, int *status);

/* The arguments of an option that may be given several times, one per call, NULL after the last.
 * *at is 0 before the first call. */
const char *options_next(const arguments *read, size_t index, size_t *at);

/* The index of the option whose name is the first `length` letters of `name`; option_count if there
 * is none. */
size_t options_find(const command_line *line, const char *name, size_t length);

#endif
