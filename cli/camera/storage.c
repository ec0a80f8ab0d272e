#include "camera/storage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Part of the file. */
typedef struct span {
    const char *at, *end;
} span;

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* The first place of `word` in a span, its end if there is none. */
static const char *find_text(span in, const char *word)
{
    size_t length = strlen(word);
    for (; (size_t)(in.end - in.at) >= length; in.at++) {
        if (memcmp(in.at, word, length) == 0) {
            return in.at;
        }
    }
    return in.end;
}

static const char *line_end(span in)
{
    const char *end = memchr(in.at, '\n', (size_t)(in.end - in.at));
    return end != NULL ? end + 1 : in.end;
}

storage storage_of(const file_bytes *file)
{
    storage of = {(const char *)file->bytes, (const char *)file->bytes + file->size, false};
    const char *first = of.text;
    while (first < of.end && is_blank(*first)) {
        first++;
    }
    of.xml = first < of.end && *first == '<';
    return of;
}

/* The key of a line of YAML that begins at `at`: returns what follows "name:", NULL if it is
 * another line. */
static const char *after_key(const char *at, const char *end, const char *name)
{
    size_t length = strlen(name);
    bool is_key = (size_t)(end - at) > length && memcmp(at, name, length) == 0 && at[length] == ':';
    return is_key ? at + length + 1 : NULL;
}

/* What belongs to a key at the top of a YAML file: up to the next line that is not indented. */
static bool yaml_top(span in, const char *name, span *found)
{
    const char *begin = NULL;
    for (; in.at < in.end && begin == NULL; in.at = line_end(in)) {
        begin = after_key(in.at, in.end, name);
    }
    if (begin == NULL) {
        return false;
    }
    while (in.at < in.end && is_blank(*in.at)) {
        in.at = line_end(in);
    }
    *found = (span){begin, in.at};
    return true;
}

/* The value of a key inside: up to the bracket that closes it, or to the end of the line. */
static bool yaml_inside(span in, const char *name, span *found)
{
    for (; in.at < in.end; in.at = line_end(in)) {
        const char *key = in.at;
        while (key < in.end && (*key == ' ' || *key == '\t')) {
            key++;
        }
        const char *value = after_key(key, in.end, name);
        if (value != NULL) {
            const span line = {value, line_end(in)};
            bool is_list = find_text(line, "[") < line.end;
            *found = (span){value, is_list ? find_text((span){value, in.end}, "]") : line.end};
            return true;
        }
    }
    return false;
}

/* What stands between <name ...> and </name>. */
static bool xml_element(span in, const char *name, span *found)
{
    size_t length = strlen(name);
    for (; in.at < in.end; in.at++) {
        in.at = find_text(in, "<");
        if ((size_t)(in.end - in.at) <= length + 1) {
            return false;
        }
        char after = in.at[length + 1];
        if (memcmp(in.at + 1, name, length) == 0 && (after == '>' || is_blank(after))) {
            const char *begin = find_text(in, ">");
            const char *end = begin;
            do { /* "</K1" may also begin "</K10>" */
                end = find_text((span){end + (end < in.end), in.end}, "</");
            } while (end < in.end &&
                     ((size_t)(in.end - end) <= length + 2 || memcmp(end + 2, name, length) != 0 ||
                      end[length + 2] != '>'));
            *found = (span){begin + (begin < in.end), end};
            return end < in.end && begin < end;
        }
    }
    return false;
}

static bool find_top(const storage *in, const char *name, span *found)
{
    const span all = {in->text, in->end};
    return in->xml ? xml_element(all, name, found) : yaml_top(all, name, found);
}

static bool find_inside(const storage *in, span whole, const char *name, span *found)
{
    return in->xml ? xml_element(whole, name, found) : yaml_inside(whole, name, found);
}

static bool separates(char c)
{
    return is_blank(c) || c == ',' || c == ';' || c == '[' || c == ']';
}

size_t storage_numbers(const char *text, const char *end, double values[MATRIX_MAX])
{
    size_t count = 0;
    while (true) {
        char word[64];
        size_t used = 0;
        while (text < end && separates(*text)) {
            text++;
        }
        if (text == end) {
            return count;
        }
        while (text < end && !separates(*text) && used + 1 < sizeof word) {
            word[used++] = *text++;
        }
        char *rest;
        word[used] = '\0';
        double value = strtod(word, &rest);
        if (count == MATRIX_MAX || *rest != '\0' || !isfinite(value)) {
            return MATRIX_MAX + 1;
        }
        values[count++] = value;
    }
}

static bool read_count(const storage *in, span whole, const char *name, size_t *count)
{
    span part;
    double values[MATRIX_MAX];
    bool read = find_inside(in, whole, name, &part) &&
                storage_numbers(part.at, part.end, values) == 1 && values[0] >= 0 &&
                values[0] <= MATRIX_MAX && values[0] == floor(values[0]);
    *count = read ? (size_t)values[0] : 0;
    return read;
}

/* OpenCV 5 writes what has one dimension as an opencv-nd-matrix, with `sizes`. */
static bool read_shape(const storage *in, span whole, matrix *read)
{
    span sizes;
    if (find_inside(in, whole, "sizes", &sizes)) {
        read->rows = 1;
        return read_count(in, whole, "sizes", &read->columns);
    }
    return read_count(in, whole, "rows", &read->rows) &&
           read_count(in, whole, "cols", &read->columns);
}

static bool read_matrix(const storage *in, span whole, matrix *read)
{
    span data;
    return read_shape(in, whole, read) && find_inside(in, whole, "data", &data) &&
           storage_numbers(data.at, data.end, read->values) == read->rows * read->columns;
}

stored_status storage_find(const storage *in, const char *name, matrix *found)
{
    span whole, part;
    memset(found, 0, sizeof *found);
    if (!find_top(in, name, &whole)) {
        return NOT_STORED;
    }
    if (find_inside(in, whole, "data", &part)) {
        return read_matrix(in, whole, found) ? STORED : STORED_BADLY;
    }
    found->rows = 1;
    found->columns = storage_numbers(whole.at, whole.end, found->values);
    return found->columns > 0 && found->columns <= MATRIX_MAX ? STORED : STORED_BADLY;
}
