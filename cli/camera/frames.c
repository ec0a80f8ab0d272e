#define _XOPEN_SOURCE 700

#include "camera/frames.h"

#include <inttypes.h>
#include <string.h>
#include <unistd.h>

#include "output.h"
#include "pictures/picture_read.h"
#include "pictures/planes.h"
#include "text/fail.h"

static int find_first(frames *of)
{
    bool is_first = true;
    for (size_t i = 0; i < of->count; i++) {
        const source *from = &of->sources[i];
        uint32_t number;
        bool found;
        if (from->kind != SOURCE_NUMBERED) {
            continue;
        }
        TRY(numbered_find(&from->files, 0, &number, &found));
        if (!found) {
            return fail(NO_RESOURCE, from->path, "no file has this name with a number in it");
        }
        if (!is_first && number != of->next) {
            return fail(BAD_INPUT, from->path,
                        "begins at number %" PRIu32 ", but %s at %" PRIu32
                        ": both have to have the same frames",
                        number, of->sources[0].path, of->next);
        }
        of->next = number;
        is_first = false;
    }
    return DONE;
}

static int check_output(const char *to)
{
    numbered names;
    return numbered_read(to, &names) || output_is_straight(to)
               ? DONE
               : fail_usage("-o %s: a sequence makes many maps: give their name a number, such as "
                            "out/d_%%04d.pfm, or - for standard output",
                            to);
}

int frames_open(const char *left, const char *right, const char *to, frames *opened)
{
    const char *paths[2] = {left, right};
    const size_t count = right != NULL ? 2 : 1;
    numbered names;
    memset(opened, 0, sizeof *opened);
    opened->count = count;
    opened->next = 1;
    opened->is_sequence = numbered_read(to, &names) || (right == NULL && strcmp(left, "-") == 0);
    for (size_t i = 0; i < count; i++) {
        source *from = &opened->sources[i];
        from->path = paths[i];
        from->kind = numbered_read(paths[i], &from->files) ? SOURCE_NUMBERED : SOURCE_PICTURE;
        opened->is_sequence |= from->kind == SOURCE_NUMBERED;
    }
    if (!opened->is_sequence) {
        return DONE;
    }
    TRY(check_output(to));
    for (size_t i = 0; i < count; i++) {
        source *from = &opened->sources[i];
        if (from->kind == SOURCE_PICTURE) {
            from->kind = SOURCE_STREAM;
            TRY(stream_open(from->path, &from->stream));
        }
    }
    return find_first(opened);
}

void frames_close(frames *closed)
{
    for (size_t i = 0; i < closed->count; i++) {
        stream_close(&closed->sources[i].stream);
    }
}

/* The name of a frame of a stream. */
static char *stream_frame_name(const source *from, uint32_t number, budget *limit)
{
    size_t size = strlen(from->stream.name) + 32;
    char *name = budget_take(limit, from->stream.name, size);
    if (name != NULL) {
        (void)snprintf(name, size, "%s, frame %" PRIu32, from->stream.name, number);
    }
    return name;
}

/* The next picture of a source, with its name. */
static int read_source(source *from, uint32_t number, budget *limit, const char **name,
                       picture *read, bool *ended)
{
    *ended = false;
    read->samples = NULL;
    switch (from->kind) {
    case SOURCE_PICTURE: *name = from->path; return picture_open(from->path, limit, read);
    case SOURCE_NUMBERED:
        *name = numbered_name(&from->files, number, limit);
        if (*name == NULL) {
            return NO_RESOURCE;
        }
        *ended = access(*name, F_OK) != 0;
        return *ended ? DONE : picture_open(*name, limit, read);
    case SOURCE_STREAM:
        *name = stream_frame_name(from, number, limit);
        return *name != NULL ? stream_next(&from->stream, *name, limit, read, ended) : NO_RESOURCE;
    }
    return NO_RESOURCE;
}

/* One half of a picture that has both of a pair. */
static int take_half(const char *name, const picture *whole, unsigned side, picture *half)
{
    *half = (picture){whole->width / 2, whole->height, whole->channels, whole->maxval, NULL};
    if (!picture_allocate(half)) {
        return fail_memory(input_name(name));
    }
    size_t row = half->width * half->channels;
    for (size_t y = 0; y < half->height; y++) {
        memcpy(half->samples + y * row, whole->samples + (2 * y + side) * row,
               row * sizeof *half->samples);
    }
    return DONE;
}

static int split(const char *name, const picture *whole, const budget *limit, picture halves[2])
{
    if (whole->width % 2 != 0) {
        return fail(BAD_INPUT, input_name(name),
                    "is %zu pixels wide: two pictures side by side have an even width",
                    whole->width);
    }
    TRY(budget_need(limit, input_name(name), bytes_product(picture_bytes(whole), 2)));
    TRY(take_half(name, whole, 0, &halves[0]));
    return take_half(name, whole, 1, &halves[1]);
}

/* Reads both pictures of a pair; picture_free frees them, also after a failure. */
static int read_pair(frames *from, budget *limit, frame_pair *read, picture both[2], bool *ended)
{
    bool is_over[2];
    picture whole;
    if (from->count == 1) {
        TRY(read_source(&from->sources[0], from->next, limit, &read->names[0], &whole, ended));
        read->names[1] = read->names[0];
        int status = *ended ? DONE : split(read->names[0], &whole, limit, both);
        picture_free(&whole);
        return status;
    }
    for (size_t i = 0; i < 2; i++) {
        TRY(read_source(&from->sources[i], from->next, limit, &read->names[i], &both[i],
                        &is_over[i]));
    }
    if (is_over[0] != is_over[1]) {
        return fail(BAD_INPUT, read->names[is_over[1]],
                    "is missing, but %s is there: both have to have the same frames",
                    read->names[is_over[0]]);
    }
    *ended = is_over[0];
    return DONE;
}

/* Makes the tables for the first pair, and looks at the size of every picture. */
static int prepare(frames *by, const char *name, const picture *seen)
{
    TRY(calibration_complete(by->by, input_name(name), seen->width, seen->height));
    if (by->by->is_rectified || by->table.width != 0) {
        return DONE;
    }
    return rectifier_make(by->by, by->whole, &by->table);
}

static int rectify(frames *by, const char *name, unsigned side, const budget *limit, picture *seen)
{
    picture made;
    TRY(prepare(by, name, seen));
    if (by->by->is_rectified) {
        return DONE;
    }
    TRY(budget_need(limit, input_name(name), bytes_product(picture_bytes(seen), 2)));
    TRY(rectifier_apply(&by->table, side, seen, input_name(name), &made));
    picture_free(seen);
    *seen = made;
    return DONE;
}

static int make_grey(frames *from, budget *limit, frame_pair *read, picture both[2])
{
    for (unsigned side = 0; side < 2; side++) {
        if (from->by != NULL) {
            TRY(rectify(from, read->names[side], side, limit, &both[side]));
        }
        TRY(picture_take_grey(read->names[side], from->bits, limit, &both[side],
                              &read->grey[side]));
    }
    return DONE;
}

/* Files that a missing one keeps from being read. */
static int warn_of_later(const frames *from)
{
    uint32_t later;
    bool found = false;
    for (size_t i = 0; i < from->count && !found; i++) {
        const source *of = &from->sources[i];
        if (of->kind == SOURCE_NUMBERED) {
            TRY(numbered_find(&of->files, from->next, &later, &found));
        }
        if (found) {
            warn(of->path,
                 "ends at number %" PRIu32 ": %" PRIu32 " is missing, but %" PRIu32 " is there",
                 from->next - 1, from->next, later);
        }
    }
    return DONE;
}

int frames_next(frames *from, budget *limit, frame_pair *read, bool *ended)
{
    picture both[2] = {{.samples = NULL}, {.samples = NULL}};
    memset(read, 0, sizeof *read);
    read->number = from->next;
    int status = read_pair(from, limit, read, both, ended);
    if (status == DONE && *ended) {
        status = from->any ? warn_of_later(from)
                           : fail(BAD_INPUT, input_name(from->sources[0].path), "has no frame");
    } else if (status == DONE) {
        status = make_grey(from, limit, read, both);
        from->any = true;
        from->next++;
    }
    picture_free(&both[0]);
    picture_free(&both[1]);
    return status;
}
