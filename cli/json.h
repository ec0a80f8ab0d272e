/* One JSON object on one line of standard output. */
#ifndef JSON_H
#define JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Opens the object and writes its first key, "schema". */
void json_begin(void);
void json_end(void);

void json_text(const char *key, const char *text, size_t size);
void json_name(const char *key, const char *text); /* terminated; NULL = null */
void json_count(const char *key, uint64_t number);
void json_integer(const char *key, int64_t number);
void json_real(const char *key, double number); /* reads back to the same double */
void json_null(const char *key);
void json_truth(const char *key, bool truth);

/* units / scale, an energy or coefficient in real units, without rounding. */
void json_units(const char *key, int64_t units, uint32_t scale);

/* A list of objects: json_list, for each json_item, its keys and json_item_end, then json_list_end.
 */
void json_list(const char *key);
void json_item(void);
void json_item_end(void);
void json_list_end(void);

/* A value that is JSON already. */
void json_raw(const char *key, const char *json, size_t size);

#endif
