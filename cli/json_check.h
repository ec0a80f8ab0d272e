/* Text from a file that should be JSON. */
#ifndef JSON_CHECK_H
#define JSON_CHECK_H

#include <stdbool.h>
#include <stddef.h>

/* One JSON object (RFC 8259), nested to a depth of at most 64, and nothing but blanks around it. */
bool json_is_object(const char *text, size_t size);

/* The number under a key (without escapes) of the outermost object of such text; false = there is
 * none. */
bool json_find_number(const char *text, size_t size, const char *key, double *number);

/* Tells each number that stands directly in the object under a key of the outermost object of such
 * text: its name and value. */
typedef void json_number_told(void *context, const char *name, size_t size, double number);
void json_each_number(const char *text, size_t size, const char *key, json_number_told *tell,
                      void *context);

#endif
