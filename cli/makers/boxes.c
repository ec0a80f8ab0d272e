#include "makers/boxes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "text/fail.h"

enum { PICTURE, X, Y, WIDTH, HEIGHT, SCORE, COLUMNS };
static const char *const column_names[COLUMNS] = {"picture", "x", "y", "width", "height", "score"};

const char kept_list_head[] = "box,keep";

enum { FIELDS_MAX = 64, HUNDREDTHS = 100 };

/* Where each column stands in a line; FIELDS_MAX = nowhere. */
typedef struct columns {
    size_t of[COLUMNS];
} columns;

static slice trimmed(slice part)
{
    while (part.size > 0 && strchr(" \t\r", part.text[0]) != NULL) {
        part.text++;
        part.size--;
    }
    while (part.size > 0 && strchr(" \t\r", part.text[part.size - 1]) != NULL) {
        part.size--;
    }
    return part;
}

/* Takes what comes before `end`, or all, off the text. */
static slice take_until(slice *rest, char end)
{
    const char *found = memchr(rest->text, (unsigned char)end, rest->size);
    size_t size = found != NULL ? (size_t)(found - rest->text) : rest->size;
    slice taken = {rest->text, size};
    size_t past = found != NULL ? size + 1 : size;
    rest->text += past;
    rest->size -= past;
    return taken;
}

static bool same(slice a, slice b)
{
    return a.size == b.size && memcmp(a.text, b.text, a.size) == 0;
}

/* Without the quotes around it. */
static slice unquoted(slice field)
{
    bool quoted = field.size >= 2 && field.text[0] == '"' && field.text[field.size - 1] == '"';
    return quoted ? (slice){field.text + 1, field.size - 2} : field;
}

/* Returns the number of fields. */
static size_t split(slice line, slice fields[FIELDS_MAX])
{
    size_t count = 0;
    do {
        fields[count++] = unquoted(trimmed(take_until(&line, ',')));
    } while (line.size > 0 && count < FIELDS_MAX);
    return count;
}

static int find_columns(const char *name, slice head, bool scored, columns *found)
{
    slice fields[FIELDS_MAX];
    size_t count = split(head, fields);
    if (same(head, (slice){kept_list_head, strlen(kept_list_head)})) {
        return fail(BAD_INPUT, name,
                    "says only which boxes are kept, not where they are: give those with --boxes "
                    "to score, or to decode, which then writes them");
    }
    for (size_t c = 0; c < COLUMNS; c++) {
        slice wanted = {column_names[c], strlen(column_names[c])};
        size_t at = 0;
        while (at < count && !same(fields[at], wanted)) {
            at++;
        }
        found->of[c] = at < count ? at : FIELDS_MAX;
        if (at == count && (c != SCORE || scored)) {
            return fail(BAD_INPUT, name,
                        "has no column %s: its first line has to name the columns picture, x, y, "
                        "width, height%s",
                        column_names[c], scored ? " and score" : "");
        }
    }
    return DONE;
}

/* Reads a decimal number and rounds it to hundredths. */
static bool read_hundredths(slice field, double least, double most, int32_t *value)
{
    char text[64], *end;
    if (field.size == 0 || field.size >= sizeof text) {
        return false;
    }
    memcpy(text, field.text, field.size);
    text[field.size] = '\0';
    double number = strtod(text, &end) * HUNDREDTHS;
    if (*end != '\0' || !(number >= least && number <= most)) {
        return false;
    }
    *value = (int32_t)lround(number);
    return true;
}

static int read_box(box_file *file, uint32_t at, const columns *places)
{
    slice fields[FIELDS_MAX + 1];
    size_t count = split(file->lines[at], fields);
    qs_box *box = &file->boxes[at];
    int32_t *const values[COLUMNS] = {NULL,        &box->x,      &box->y,
                                      &box->width, &box->height, &box->score};
    *box = (qs_box){.picture = at};
    for (size_t c = 0; c < COLUMNS; c++) {
        double most = c == SCORE ? QS_BOX_SCORE_MAX : QS_BOX_PLACE_MAX;
        double least = c == WIDTH || c == HEIGHT ? 1 : -most;
        size_t place = places->of[c];
        if (place == FIELDS_MAX) {
            continue;
        }
        if (place >= count ||
            (c != PICTURE && !read_hundredths(fields[place], least, most, values[c]))) {
            return fail(BAD_INPUT, file->name, "box %lu: its %s is missing or no number that fits",
                        (unsigned long)at + 1, column_names[c]);
        }
    }
    file->pictures[at] = fields[places->of[PICTURE]];
    return DONE;
}

/* Boxes of one picture mostly stand together: the last one is looked at first. */
static void number_pictures(box_file *file)
{
    for (uint32_t i = 1; i < file->count; i++) {
        if (same(file->pictures[i], file->pictures[i - 1])) {
            file->boxes[i].picture = file->boxes[i - 1].picture;
            continue;
        }
        for (uint32_t j = 0; j < i; j++) {
            if (same(file->pictures[i], file->pictures[j])) {
                file->boxes[i].picture = file->boxes[j].picture;
                break;
            }
        }
    }
}

static uint32_t count_lines(slice rest)
{
    uint32_t count = 0;
    while (rest.size > 0) {
        count += trimmed(take_until(&rest, '\n')).size > 0;
    }
    return count;
}

static int take_room(box_file *file, budget *limit)
{
    file->lines = budget_take(limit, file->name, file->count * sizeof *file->lines);
    file->pictures = budget_take(limit, file->name, file->count * sizeof *file->pictures);
    file->boxes = budget_take(limit, file->name, file->count * sizeof *file->boxes);
    return file->lines != NULL && file->pictures != NULL && file->boxes != NULL ? DONE
                                                                                : NO_RESOURCE;
}

int boxes_read(const char *path, bool scored, budget *limit, box_file *read)
{
    file_bytes bytes;
    columns places;
    TRY(file_read(path, limit, &bytes));
    slice rest = {(const char *)bytes.bytes, bytes.size};
    if (rest.size >= 3 && memcmp(rest.text, "\xEF\xBB\xBF", 3) == 0) {
        (void)take_until(&rest, '\xBF'); /* the mark of UTF-8 that spreadsheets write */
    }
    *read = (box_file){.name = input_name(path)};
    read->head = trimmed(take_until(&rest, '\n'));
    TRY(find_columns(read->name, read->head, scored, &places));
    read->count = count_lines(rest);
    TRY(take_room(read, limit));
    for (uint32_t at = 0; at < read->count;) {
        slice line = trimmed(take_until(&rest, '\n'));
        if (line.size > 0) {
            read->lines[at] = line;
            TRY(read_box(read, at, &places));
            at++;
        }
    }
    number_pictures(read);
    return DONE;
}

static void write_line(slice line, output *out)
{
    (void)output_write(out, line.text, line.size);
    (void)output_write(out, "\n", 1);
}

void boxes_write(const box_file *of, const uint16_t *kept, output *out)
{
    write_line(of->head, out);
    for (uint32_t i = 0; i < of->count; i++) {
        if (kept[i] == 1) {
            write_line(of->lines[i], out);
        }
    }
}

static double common(double a, double a_size, double b, double b_size)
{
    return fmax(0, fmin(a + a_size, b + b_size) - fmax(a, b));
}

double boxes_overlap(const qs_box *a, const qs_box *b)
{
    double shared =
        common(a->x, a->width, b->x, b->width) * common(a->y, a->height, b->y, b->height);
    double covered = (double)a->width * a->height + (double)b->width * b->height - shared;
    return shared / covered;
}
