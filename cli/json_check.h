/* Text from a file that should be JSON. */
#ifndef JSON_CHECK_H
#define JSON_CHECK_H

#include <stdbool.h>
#include <stddef.h>

/* One JSON object (RFC 8259), nested to a depth of at most 64, and nothing but blanks around it. */
bool json_is_object(const char *text, size_t size);

/* The number under a key (without escapes) of the outermost object of such text; false = there is none. */
bool json_find_number(const char *text, size_t size, const char *key, double *number);

#endif
