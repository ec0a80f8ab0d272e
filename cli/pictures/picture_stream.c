#define _XOPEN_SOURCE 700

#include "pictures/picture_stream.h"

#include <stdlib.h>
#include <string.h>

#include "text/fail.h"

enum { LINE_SIZE = 1024, LARGEST = 1 << 20 };

int stream_open(const char *path, picture_stream *opened)
{
    memset(opened, 0, sizeof *opened);
    opened->name = input_name(path);
    opened->file = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    if (opened->file == NULL) {
        return fail_system(opened->name, "cannot be opened");
    }
    file_remember(fileno(opened->file));
    return DONE;
}

void stream_close(picture_stream *closed)
{
    if (closed->file != NULL && closed->file != stdin) {
        (void)fclose(closed->file);
    }
    closed->file = NULL;
}

static int fail_read(const picture_stream *from, const char *name)
{
    return ferror(from->file) ? fail_system(name, "cannot be read")
                              : fail(BAD_INPUT, name, "ends before its last sample");
}

/* Reads a line without its end. Returns false if there is none, or if it is too long. */
static bool read_line(FILE *file, char line[LINE_SIZE])
{
    if (fgets(line, LINE_SIZE, file) == NULL) {
        return false;
    }
    size_t length = strcspn(line, "\n");
    bool whole = line[length] == '\n';
    line[length] = '\0';
    return whole;
}

static bool read_size(const char *digits, size_t *size)
{
    char *end;
    unsigned long value = strtoul(digits, &end, 10);
    *size = value;
    return *digits >= '1' && *digits <= '9' && *end == '\0' && value <= LARGEST;
}

/* The samples of colour of a picture, for the name of a colour space: 420jpeg, 422p10, mono. Sets
 * the bits of a sample. Returns false if the name is unknown. */
static bool read_colour_space(const char *space, const picture *form, uint64_t *samples,
                              unsigned *bits)
{
    static const struct {
        const char *name;
        unsigned wide, high; /* pixels of a sample of colour */
        unsigned planes;
    } known[] = {{"mono", 1, 1, 0}, {"420", 2, 2, 2},      {"422", 2, 1, 2},
                 {"411", 4, 1, 2},  {"444alpha", 1, 1, 3}, {"444", 1, 1, 2}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        size_t length = strlen(known[i].name);
        if (strncmp(space, known[i].name, length) != 0) {
            continue;
        }
        const char *depth = space + length + (space[length] == 'p' && known[i].planes > 0);
        size_t stated = 8;
        if (*depth >= '0' && *depth <= '9' && !read_size(depth, &stated)) {
            return false;
        }
        *bits = (unsigned)stated;
        *samples = known[i].planes * ((form->width + known[i].wide - 1) / known[i].wide) *
                   ((form->height + known[i].high - 1) / known[i].high);
        return stated >= 8 && stated <= 16;
    }
    return false;
}

/* The first line of a Y4M, after its first letter: words with a letter each that says what they
 * are. */
static int read_y4m_header(picture_stream *from)
{
    char line[LINE_SIZE], *rest = NULL;
    const char *space = "420";
    unsigned bits = 8;
    bool is_header = read_line(from->file, line) && strncmp(line, "UV4MPEG2", 8) == 0;
    from->form.channels = 1;
    for (char *word = is_header ? strtok_r(line, " ", &rest) : NULL; is_header && word != NULL;
         word = strtok_r(NULL, " ", &rest)) {
        switch (*word) {
        case 'W': is_header = read_size(word + 1, &from->form.width); break;
        case 'H': is_header = read_size(word + 1, &from->form.height); break;
        case 'C': space = word + 1; break;
        default: break;
        }
    }
    if (!is_header || from->form.width == 0 || from->form.height == 0 ||
        !read_colour_space(space, &from->form, &from->skipped, &bits)) {
        return fail(BAD_INPUT, from->name,
                    "is a Y4M whose header cannot be read, or of another kind than 8 to 16 bits");
    }
    from->y4m = true;
    from->form.maxval = (1u << bits) - 1;
    from->skipped *= bits > 8 ? 2 : 1;
    return DONE;
}

static int skip_bytes(picture_stream *from, const char *name)
{
    char skipped[4096];
    for (uint64_t left = from->skipped; left > 0;) {
        size_t part = left < sizeof skipped ? (size_t)left : sizeof skipped;
        if (fread(skipped, 1, part, from->file) != part) {
            return fail_read(from, name);
        }
        left -= part;
    }
    return DONE;
}

/* Reads the samples of a picture whose form is known: 2 bytes each have the low one first in a Y4M,
 * and the high one in a PGM. */
static int read_samples(picture_stream *from, const char *name, const budget *limit, picture *read)
{
    size_t count = read->width * read->height * read->channels, bytes = read->maxval > 255 ? 2 : 1;
    unsigned low = from->y4m ? 0 : (unsigned)bytes - 1, high = (unsigned)bytes - 1 - low;
    TRY(budget_need(limit, name, bytes_product(picture_bytes(read), 2)));
    uint8_t *held = malloc(count * bytes);
    if (held == NULL || !picture_allocate(read)) {
        free(held);
        return fail_memory(name);
    }
    int status = fread(held, bytes, count, from->file) == count ? DONE : fail_read(from, name);
    for (size_t i = 0; i < count && status == DONE; i++) {
        const uint8_t *at = held + i * bytes;
        read->samples[i] = (uint16_t)(bytes == 2 ? at[low] | at[high] << 8 : at[0]);
        if (read->samples[i] > read->maxval) {
            status = fail(BAD_INPUT, name, "has a sample above its largest value");
        }
    }
    free(held);
    if (status != DONE) {
        picture_free(read);
    }
    return status;
}

static bool is_blank(int byte)
{
    return byte == ' ' || (byte >= '\t' && byte <= '\r');
}

/* The next byte of a header, with a comment as the end of its line. */
static int next_byte(FILE *file)
{
    int byte = getc(file);
    if (byte == '#') {
        while (byte != '\n' && byte != EOF) {
            byte = getc(file);
        }
    }
    return byte;
}

/* The next number of the header of a PGM or PPM. Takes the byte that ends it. Returns 0 if there is
 * none. */
static uint32_t read_number(FILE *file)
{
    uint32_t number = 0;
    int byte = next_byte(file);
    while (is_blank(byte)) {
        byte = next_byte(file);
    }
    for (; byte >= '0' && byte <= '9' && number <= LARGEST; byte = next_byte(file)) {
        number = number * 10 + (uint32_t)(byte - '0');
    }
    return is_blank(byte) && number <= LARGEST ? number : 0;
}

static int read_pnm_header(picture_stream *from, const char *name, picture *read)
{
    int kind = getc(from->file);
    *read = (picture){.channels = kind == '6' ? 3 : 1};
    if (kind == '5' || kind == '6') {
        read->width = read_number(from->file);
        read->height = read_number(from->file);
        read->maxval = read_number(from->file);
    }
    if (read->width == 0 || read->height == 0 || read->maxval == 0 || read->maxval > 65535) {
        return fail(BAD_INPUT, name, "has no header of a binary PGM or PPM");
    }
    return DONE;
}

static int read_y4m_frame(picture_stream *from, const char *name, const budget *limit,
                          picture *read)
{
    char line[LINE_SIZE];
    *read = from->form;
    if (!read_line(from->file, line) || strncmp(line, "RAME", 4) != 0) {
        return fail(BAD_INPUT, name, "does not begin with FRAME");
    }
    TRY(read_samples(from, name, limit, read));
    int status = skip_bytes(from, name);
    if (status != DONE) {
        picture_free(read);
    }
    return status;
}

static int read_pnm_frame(picture_stream *from, const char *name, const budget *limit,
                          picture *read)
{
    TRY(read_pnm_header(from, name, read));
    return read_samples(from, name, limit, read);
}

int stream_next(picture_stream *from, const char *name, const budget *limit, picture *read,
                bool *ended)
{
    int first = getc(from->file);
    bool begins = from->count == 0;
    if (first == 'Y' && begins) {
        TRY(read_y4m_header(from));
        first = getc(from->file);
    }
    *ended = first == EOF;
    if (first == EOF) {
        return ferror(from->file) ? fail_system(name, "cannot be read") : DONE;
    }
    if (first != (from->y4m ? 'F' : 'P')) {
        return fail(BAD_INPUT, begins ? from->name : name,
                    "is no picture of a stream: frames are binary PGM, PPM or Y4M%s",
                    begins ? " (ffmpeg -f yuv4mpegpipe); a sequence of files has a number in its "
                             "name, such as left_%04d.png"
                           : "");
    }
    from->count++;
    return (from->y4m ? read_y4m_frame : read_pnm_frame)(from, name, limit, read);
}
