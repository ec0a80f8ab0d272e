#include "text/json.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/numbers.h"
#include "text/plain.h"

/* The number of the set of keys, not that of the file format. */
enum { SCHEMA = 1 };

/* True while the object or list that is being written is empty. */
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

/* A value that is JSON already. */
static void json_raw(const char *key, const char *json, size_t size)
{
    write_key(key);
    (void)fwrite(json, 1, size, stdout);
}

/* JSON is UTF-8: in the place of a stray byte stands the character for that. */
static void write_character(const char *text, const character *of)
{
    if (of->plain) {
        (void)fwrite(text, 1, of->length, stdout);
    } else {
        printf("\\u%04lx", of->stray ? 0xFFFDUL : (unsigned long)of->code);
    }
}

void json_object(const char *key, const char *json, size_t size)
{
    write_key(key);
    for (size_t at = 0; at < size;) {
        character next = character_at(json + at, size - at);
        if (next.code < 0x20) {
            putchar(json[at]); /* a blank between tokens: in a string there is none */
        } else {
            write_character(json + at, &next);
        }
        at += next.length;
    }
}

void json_text(const char *key, const char *text, size_t size)
{
    write_key(key);
    putchar('"');
    for (size_t at = 0; at < size;) {
        character next = character_at(text + at, size - at);
        if (next.code == '"' || next.code == '\\') {
            putchar('\\');
        }
        write_character(text + at, &next);
        at += next.length;
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

enum { DEPTH_MAX = 64 };

void json_units_or_null(const char *key, bool there, int64_t units, uint32_t scale)
{
    if (there) {
        json_units(key, units, scale);
    } else {
        json_null(key);
    }
}

/* Where the reader is. Each step moves `at` over what it expects, or returns false. */
typedef struct reader {
    const char *at, *end;
    char closers[DEPTH_MAX]; /* of the objects and arrays that are open */
    size_t depth;
    const char *wanted; /* a key of the outermost object; NULL = none. Its value is at `found` */
    const char *found;
} reader;

static char peek(const reader *from)
{
    return from->at < from->end ? *from->at : '\0';
}

static bool take(reader *from, char wanted)
{
    bool there = from->at < from->end && *from->at == wanted;
    from->at += there;
    return there;
}

static void skip_blanks(reader *from)
{
    while (from->at < from->end && memchr(" \t\r\n", *from->at, 4) != NULL) {
        from->at++;
    }
}

static bool take_digits(reader *from)
{
    const char *start = from->at;
    while (peek(from) >= '0' && peek(from) <= '9') {
        from->at++;
    }
    return from->at > start;
}

/* More than any program writes of a double. */
enum { LONGEST_NUMBER = 1000 };

/* What a double holds: 1e999 would be infinite to whoever computes with it. */
static bool is_finite(const char *at, size_t length)
{
    char digits[LONGEST_NUMBER + 1]; /* strtod needs an end */
    if (length > LONGEST_NUMBER) {
        return false;
    }
    memcpy(digits, at, length);
    digits[length] = '\0';
    return isfinite(strtod(digits, NULL));
}

static bool take_figure(reader *from)
{
    (void)take(from, '-');
    if (!take(from, '0') && !take_digits(from)) {
        return false;
    }
    if (take(from, '.') && !take_digits(from)) {
        return false;
    }
    if (take(from, 'e') || take(from, 'E')) {
        if (!take(from, '-')) {
            (void)take(from, '+');
        }
        return take_digits(from);
    }
    return true;
}

static bool take_number(reader *from)
{
    const char *at = from->at;
    return take_figure(from) && is_finite(at, (size_t)(from->at - at));
}

static bool take_escape(reader *from)
{
    static const char hexadecimals[] = "0123456789abcdefABCDEF";
    if (!take(from, 'u')) {
        bool known = from->at < from->end && memchr("\"\\/bfnrt", *from->at, 8) != NULL;
        from->at += known;
        return known;
    }
    for (int i = 0; i < 4; i++, from->at++) {
        if (from->at == from->end ||
            memchr(hexadecimals, *from->at, sizeof hexadecimals - 1) == NULL) {
            return false;
        }
    }
    return true;
}

static bool take_string(reader *from)
{
    if (!take(from, '"')) {
        return false;
    }
    while (from->at < from->end && *from->at != '"') {
        if ((unsigned char)*from->at < 0x20) {
            return false;
        }
        if (*from->at++ == '\\' && !take_escape(from)) {
            return false;
        }
    }
    return take(from, '"');
}

static bool take_word(reader *from, const char *word)
{
    size_t length = strlen(word);
    if ((size_t)(from->end - from->at) < length || memcmp(from->at, word, length) != 0) {
        return false;
    }
    from->at += length;
    return true;
}

static bool take_scalar(reader *from)
{
    if (peek(from) == '"') {
        return take_string(from);
    }
    return take_word(from, "true") || take_word(from, "false") || take_word(from, "null") ||
           take_number(from);
}

static bool take_key(reader *from)
{
    skip_blanks(from);
    const char *key = from->at + 1;
    if (!take_string(from)) {
        return false;
    }
    size_t length = (size_t)(from->at - 1 - key);
    skip_blanks(from);
    if (!take(from, ':')) {
        return false;
    }
    if (from->wanted != NULL && from->depth == 1 && strlen(from->wanted) == length &&
        memcmp(from->wanted, key, length) == 0) {
        skip_blanks(from);
        from->found = from->at;
    }
    return true;
}

/* Enters the object or array that begins here. An empty one is left at once: it is complete. */
static bool open_nested(reader *from, bool *complete)
{
    char closer = *from->at++ == '{' ? '}' : ']';
    skip_blanks(from);
    *complete = take(from, closer);
    if (*complete) {
        return true;
    }
    if (from->depth == DEPTH_MAX) {
        return false;
    }
    from->closers[from->depth++] = closer;
    return closer == ']' || take_key(from);
}

/* After a complete value: leaves what ends here, then steps over the comma before the next one. */
static bool close_nested(reader *from)
{
    skip_blanks(from);
    while (from->depth > 0 && take(from, from->closers[from->depth - 1])) {
        from->depth--;
        skip_blanks(from);
    }
    if (from->depth == 0) {
        return true;
    }
    return take(from, ',') && (from->closers[from->depth - 1] == ']' || take_key(from));
}

/* Steps over a whole value of any kind and the blanks after it. */
static bool take_value(reader *from)
{
    do {
        bool complete = true;
        skip_blanks(from);
        bool known = peek(from) == '{' || peek(from) == '[' ? open_nested(from, &complete)
                                                            : take_scalar(from);
        if (!known || (complete && !close_nested(from))) {
            return false;
        }
    } while (from->depth > 0);
    return true;
}

static bool take_object(reader *from)
{
    skip_blanks(from);
    return peek(from) == '{' && take_value(from) && from->at == from->end;
}

bool json_is_object(const char *text, size_t size)
{
    reader from = {text, text + size, {0}, 0, NULL, NULL};
    return take_object(&from);
}

/* Where the value of a key of the outermost object begins; NULL if there is no such key, or if the
 * text is not an object. */
static const char *find_value(const char *text, size_t size, const char *key)
{
    reader from = {text, text + size, {0}, 0, key, NULL};
    return take_object(&from) ? from.found : NULL;
}

/* Reads the number that begins at `at`. Returns false if there is none. */
static bool read_number(const char *at, const char *end, double *number)
{
    char digits[64] = "";
    reader value = {at, end, {0}, 0, NULL, NULL};
    if (!take_number(&value) || (size_t)(value.at - at) >= sizeof digits) {
        return false;
    }
    /* strtod needs a copy that ends with a 0 byte. */
    memcpy(digits, at, (size_t)(value.at - at));
    *number = strtod(digits, NULL);
    return true;
}

bool json_find_number(const char *text, size_t size, const char *key, double *number)
{
    const char *found = find_value(text, size, key);
    return found != NULL && read_number(found, text + size, number);
}

void json_each_number(const char *text, size_t size, const char *key, json_number_told *tell,
                      void *context)
{
    const char *found = find_value(text, size, key);
    reader from = {found, text + size, {0}, 0, NULL, NULL};
    if (found == NULL || !take(&from, '{')) {
        return;
    }
    for (;;) {
        skip_blanks(&from);
        const char *name = from.at + 1;
        if (!take_string(&from)) {
            return;
        }
        size_t length = (size_t)(from.at - 1 - name);
        skip_blanks(&from);
        (void)take(&from, ':');
        skip_blanks(&from);
        double number;
        if (read_number(from.at, from.end, &number)) {
            tell(context, name, length, number);
        }
        if (!take_value(&from) || !take(&from, ',')) {
            return;
        }
    }
}
