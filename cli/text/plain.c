#include "text/plain.h"

#include <string.h>

/* Bytes of a UTF-8 sequence, by its first byte; 0 = none begins with it. */
static size_t length_of(uint8_t first)
{
    if (first < 0x80) {
        return 1;
    }
    return first >= 0xC2 && first < 0xE0   ? 2
           : first >= 0xE0 && first < 0xF0 ? 3
           : first >= 0xF0 && first < 0xF5 ? 4
                                           : 0;
}

/* Decodes a sequence. Returns false if it is none, or a longer one than is needed. */
static bool decode(const uint8_t *bytes, size_t length, uint32_t *code)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    *code = length == 1 ? bytes[0] : bytes[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((bytes[i] & 0xC0) != 0x80) {
            return false;
        }
        *code = *code << 6 | (bytes[i] & 0x3Fu);
    }
    return *code >= least[length] && *code <= 0x10FFFF && (*code < 0xD800 || *code > 0xDFFF);
}

static bool is_plain(uint32_t code)
{
    bool control = code < 0x20 || (code >= 0x7F && code < 0xA0);
    bool direction = code == 0x061C || code == 0x200E || code == 0x200F ||
                     (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
    bool line = code == 0x2028 || code == 0x2029;
    return !control && !direction && !line;
}

character character_at(const char *text, size_t size)
{
    const uint8_t *bytes = (const uint8_t *)text;
    size_t length = length_of(bytes[0]);
    uint32_t code;
    if (length == 0 || length > size || !decode(bytes, length, &code)) {
        return (character){1, bytes[0], true, false};
    }
    return (character){length, code, false, is_plain(code)};
}

enum { ESCAPE_SIZE = 8 };

/* Writes a character as it is shown. Returns how many bytes that is. */
static size_t write_shown(const char *text, const character *of, char shown[ESCAPE_SIZE])
{
    if (of->plain) {
        memcpy(shown, text, of->length);
        return of->length;
    }
    unsigned long code = of->code;
    int size = of->stray || code < 0x80 ? snprintf(shown, ESCAPE_SIZE, "\\x%02lx", code)
                                        : snprintf(shown, ESCAPE_SIZE, "\\u%04lx", code);
    return (size_t)size;
}

void plain_print(FILE *file, const char *text, size_t size)
{
    char shown[ESCAPE_SIZE];
    for (size_t at = 0; at < size;) {
        character next = character_at(text + at, size - at);
        size_t length = write_shown(text + at, &next, shown);
        (void)fwrite(shown, 1, length, file);
        at += next.length;
    }
}

const char *plain_text(const char *text, size_t size)
{
    enum { KEPT = 4, MOST = 4000 };
    static char kept[KEPT][MOST + ESCAPE_SIZE];
    static unsigned turn;
    char *made = kept[turn++ % KEPT];
    size_t used = 0;
    for (size_t at = 0; at < size && used < MOST;) {
        character next = character_at(text + at, size - at);
        used += write_shown(text + at, &next, made + used);
        at += next.length;
    }
    made[used] = '\0';
    return made;
}

const char *plain(const char *text)
{
    return plain_text(text, strlen(text));
}
