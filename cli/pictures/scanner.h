/* The header of a Netpbm file: words with blanks between them and comments from # to the end of
 * the line, and then, in binary files, where the samples begin. */
#ifndef SCANNER_H
#define SCANNER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "files.h"

typedef struct scanner {
    const uint8_t *at, *end;
} scanner;

/* Starts after the two letters that name the format. */
scanner scanner_start(const file_bytes *file);

/* Steps over blanks and comments. */
void scanner_skip_blanks(scanner *from);

/* Reads a word into `text`. Returns false if there is none, or no room for it. */
bool scanner_word(scanner *from, char *text, size_t size);

/* Reads a whole number up to 2^31 - 1 that a blank, a comment or the end follows. */
bool scanner_number(scanner *from, uint32_t *number);

/* Steps over blanks and comments. Returns true if nothing else is left. */
bool scanner_at_end(scanner *from);

/* Steps from the last word of a header to its samples, and checks that the file ends where they
 * do. One blank ends a header, or a comment with its line end, as in netpbm. CR LF is one blank
 * where the file is longer by a byte than it would be with a lone CR. A line end may follow the
 * samples, unless it is as long as a row, which it might be.
 *
 * size  of all samples, in bytes
 * row   of one row of samples, in bytes
 *
 * Returns NULL, or what is wrong. */
const char *scanner_samples(scanner *from, size_t size, size_t row);

#endif
