#include "scanner.h"

static bool is_blank(uint8_t c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static void skip_blanks(scanner *from)
{
    bool comment = false;
    for (; from->at < from->end; from->at++) {
        if (*from->at == '#') {
            comment = true;
        } else if (*from->at == '\n' || *from->at == '\r') {
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
    skip_blanks(from);
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

bool scanner_one_blank(scanner *from)
{
    return from->at < from->end && is_blank(*from->at++);
}

bool scanner_at_end(scanner *from)
{
    skip_blanks(from);
    return from->at == from->end;
}
