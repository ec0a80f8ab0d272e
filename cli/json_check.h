/* Whether text from a file may be passed on as JSON. */
#ifndef JSON_CHECK_H
#define JSON_CHECK_H

#include <stdbool.h>
#include <stddef.h>

/* One JSON object (RFC 8259), nested to a depth of at most 64, and nothing but blanks around it. */
bool json_is_object(const char *text, size_t size);

#endif
