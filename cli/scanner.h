/* The words of a Netpbm header: separated by blanks, with comments from # to the end of the line.
 */
#ifndef SCANNER_H
#define SCANNER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "files.h"

typedef struct scanner {
    const uint8_t *at, *end;
} scanner;

/* Starts behind the two letters that say the format. */
scanner scanner_start(const file_bytes *file);

/* Reads a whole number up to 2^31 - 1 that a blank, a comment or the end follows. */
bool scanner_number(scanner *from, uint32_t *number);

/* Reads a word into `text`. */
bool scanner_word(scanner *from, char *text, size_t size);

/* Steps over the one blank between a header and binary samples. */
bool scanner_one_blank(scanner *from);

/* Steps over all blanks and comments; true = nothing else is left. */
bool scanner_at_end(scanner *from);

#endif
