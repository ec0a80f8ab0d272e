#include "pictures/scanner.h"

static bool is_blank(uint8_t c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static bool ends_line(uint8_t c)
{
    return c == '\n' || c == '\r';
}

void scanner_skip_blanks(scanner *from)
{
    bool comment = false;
    for (; from->at < from->end; from->at++) {
        if (*from->at == '#') {
            comment = true;
        } else if (ends_line(*from->at)) {
            comment = false;
        } else if (!comment && !is_blank(*from->at)) {
            break;
        }
    }
}

scanner scanner_start(const file_bytes *file)
{
    return (scanner){file->bytes + 2, file->bytes + file->size};
}

bool scanner_word(scanner *from, char *text, size_t size)
{
    size_t used = 0;
    scanner_skip_blanks(from);
    while (from->at < from->end && !is_blank(*from->at) && *from->at != '#') {
        if (used + 1 == size) {
            return false;
        }
        text[used++] = (char)*from->at++;
    }
    text[used] = '\0';
    return used > 0;
}

bool scanner_number(scanner *from, uint32_t *number)
{
    char text[11];
    uint64_t value = 0;
    if (!scanner_word(from, text, sizeof text)) {
        return false;
    }
    for (const char *digit = text; *digit != '\0'; digit++) {
        if (*digit < '0' || *digit > '9') {
            return false;
        }
        value = value * 10 + (uint64_t)(*digit - '0');
    }
    *number = (uint32_t)value;
    return value <= INT32_MAX;
}

bool scanner_at_end(scanner *from)
{
    scanner_skip_blanks(from);
    return from->at == from->end;
}

static size_t bytes_left(const scanner *from)
{
    return (size_t)(from->end - from->at);
}

/* Steps over the blank that ends a header, and over a comment that touches its last word. */
static bool end_header(scanner *from, size_t size)
{
    if (from->at < from->end && *from->at == '#') {
        while (from->at < from->end && !ends_line(*from->at)) {
            from->at++;
        }
    }
    if (from->at == from->end || !is_blank(*from->at)) {
        return false;
    }
    bool carriage_return = *from->at++ == '\r';
    if (carriage_return && bytes_left(from) > size && *from->at == '\n') {
        from->at++;
    }
    return true;
}

static bool is_line_end(const uint8_t *bytes, size_t size)
{
    return (size == 1 && bytes[0] == '\n') || (size == 2 && bytes[0] == '\r' && bytes[1] == '\n');
}

const char *scanner_samples(scanner *from, size_t size, size_t row)
{
    if (!end_header(from, size)) {
        return "no line end follows its header";
    }
    size_t left = bytes_left(from);
    if (left < size) {
        return "it ends before its last sample";
    }
    size_t more = left - size;
    if (more > 0 && (more == row || !is_line_end(from->end - more, more))) {
        return "something follows its last sample";
    }
    return NULL;
}
