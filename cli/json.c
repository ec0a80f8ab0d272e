#include "json.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "decimal.h"

/* Of the keys, not of the files. */
enum { SCHEMA = 1 };

/* Whether nothing stands yet in the object or list that is being written. */
static bool first;

static void write_comma(void)
{
    if (!first) {
        fputs(", ", stdout);
    }
    first = false;
}

static void write_key(const char *key)
{
    write_comma();
    printf("\"%s\": ", key);
}

void json_begin(void)
{
    putchar('{');
    first = true;
    json_count("schema", SCHEMA);
}

void json_end(void)
{
    puts("}");
}

void json_list(const char *key)
{
    write_key(key);
    putchar('[');
    first = true;
}

void json_item(void)
{
    write_comma();
    putchar('{');
    first = true;
}

void json_item_end(void)
{
    putchar('}');
    first = false;
}

void json_list_end(void)
{
    putchar(']');
    first = false;
}

void json_raw(const char *key, const char *json, size_t size)
{
    write_key(key);
    (void)fwrite(json, 1, size, stdout);
}

void json_text(const char *key, const char *text, size_t size)
{
    write_key(key);
    putchar('"');
    for (size_t i = 0; i < size; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c < 0x20) {
            printf("\\u%04x", c);
        } else if (c == '"' || c == '\\') {
            printf("\\%c", c);
        } else {
            putchar(c);
        }
    }
    putchar('"');
}

void json_name(const char *key, const char *text)
{
    if (text == NULL) {
        json_null(key);
    } else {
        json_text(key, text, strlen(text));
    }
}

void json_count(const char *key, uint64_t number)
{
    write_key(key);
    printf("%" PRIu64, number);
}

void json_integer(const char *key, int64_t number)
{
    write_key(key);
    printf("%" PRId64, number);
}

void json_real(const char *key, double number)
{
    write_key(key);
    printf("%.17g", number);
}

void json_null(const char *key)
{
    json_raw(key, "null", 4);
}

void json_truth(const char *key, bool truth)
{
    json_raw(key, truth ? "true" : "false", truth ? 4 : 5);
}

void json_units(const char *key, int64_t units, uint32_t scale)
{
    char text[DECIMAL_SIZE];
    decimal_write(units, scale, text);
    json_raw(key, text, strlen(text));
}
