/* Text from outside, such as names of files and of solvers, shown so that it cannot steer a
 * terminal or hide what it says. Control characters (C0, DEL and C1), marks of the direction of
 * writing, separators of lines and bytes that are no UTF-8 are escaped: \x1b, \u202e. */
#ifndef PLAIN_H
#define PLAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* The character that text begins with. */
typedef struct character {
    size_t length; /* in bytes, at least 1 */
    uint32_t code; /* of Unicode; of a stray byte its value */
    bool stray; /* no UTF-8 */
    bool plain; /* may be shown as it is */
} character;

/* size  of the text, at least 1 */
character character_at(const char *text, size_t size);

void plain_print(FILE *file, const char *text, size_t size);

/* The same in memory of this file, for printf. It is there until the fourth next call, and cut
 * after 4,000 bytes. */
const char *plain(const char *text);
const char *plain_text(const char *text, size_t size);

#endif
