/* JSON: writing one object on one line of standard output, and reading text that a file holds. */
#ifndef JSON_H
#define JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Opens the object and writes its first key, "schema". */
void json_begin(void);
void json_end(void);

/* One key with its value. What plain.h does not show as it is, is escaped. */
void json_text(const char *key, const char *text, size_t size);
void json_name(const char *key, const char *text); /* ends with a 0 byte; NULL is null */
void json_count(const char *key, uint64_t number);
void json_integer(const char *key, int64_t number);
void json_real(const char *key, double number); /* reads back as the same double */
void json_null(const char *key);
void json_truth(const char *key, bool truth);
void json_object(const char *key, const char *json, size_t size); /* of a file */

/* units / scale, an energy or coefficient in real units, without rounding. */
void json_units(const char *key, int64_t units, uint32_t scale);

/* The same, or null if the value is not there. */
void json_units_or_null(const char *key, bool there, int64_t units, uint32_t scale);

/* A list of objects: json_list, then for each object json_item, its keys and json_item_end, then
 * json_list_end. */
void json_list(const char *key);
void json_item(void);
void json_item_end(void);
void json_list_end(void);

/* Returns true if the text is one JSON object (RFC 8259), nested at most 64 deep, with nothing but
 * blanks around it. The two functions below take such text. */
bool json_is_object(const char *text, size_t size);

/* Finds the number under a key (without escapes) of the outermost object. Returns false if there
 * is none. */
bool json_find_number(const char *text, size_t size, const char *key, double *number);

/* Calls `tell` with the name and value of each number that stands directly in the object under a
 * key of the outermost object. */
typedef void json_number_told(void *context, const char *name, size_t size, double number);
void json_each_number(const char *text, size_t size, const char *key, json_number_told *tell,
                      void *context);

#endif
