#include "meaning_output.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "arrays/npy.h"
#include "pictures/picture_library.h"
#include "pictures/picture_write.h"
#include "text/fail.h"

static int read_list(const char *path, meaning_output *asked)
{
    asked->format = MEANING_LIST;
    return path_ends(path, ".csv") || output_is_straight(path)
               ? DONE
               : fail_usage("-o %s: this problem keeps or drops boxes: the name of its list ends "
                            "in .csv",
                            path);
}

static int read_numbers(const char *name, const qs_labels *labels, const char *path,
                        meaning_output *asked)
{
    if (labels->width == 0) {
        return fail(BAD_INPUT, name,
                    "is not a problem on a grid of pixels, so no picture can be made from it: "
                    "write a .npy");
    }
    asked->format = MEANING_PICTURE;
    return picture_format_read(path, &asked->png);
}

int meaning_output_read(const char *name, const qs_labels *labels, const char *path,
                        meaning_output *asked)
{
    memset(asked, 0, sizeof *asked);
    if (path_ends(path, ".npy")) {
        asked->format = MEANING_ARRAY;
        return DONE;
    }
    switch (labels->meaning.kind) {
    case QS_MEANS_KEEP: return read_list(path, asked);
    case QS_MEANS_DISPLACEMENT:
        asked->format = MEANING_FIELD;
        return flow_format_read(path, &asked->png);
    case QS_MEANS_NUMBER: return read_numbers(name, labels, path, asked);
    case QS_MEANS_DISPARITY:
    case QS_MEANS_GREY:
    case QS_MEANS_CLASS: break;
    }
    return picture_format_read(path, &asked->png);
}

const char *meaning_output_ending(const qs_labels *labels)
{
    switch (labels->meaning.kind) {
    case QS_MEANS_KEEP: return "csv";
    case QS_MEANS_DISPLACEMENT: return "flo";
    case QS_MEANS_NUMBER: return "npy";
    case QS_MEANS_DISPARITY:
    case QS_MEANS_GREY:
    case QS_MEANS_CLASS: break;
    }
    return picture_library_writes_png() ? "png" : "pgm";
}

static void write_list(const qs_labels *labels, const uint16_t *labelling, output *to)
{
    fputs("box,keep\n", to->file);
    for (uint32_t i = 0; i < labels->sites; i++) {
        fprintf(to->file, "%" PRIu32 ",%d\n", i + 1, labelling[i] == 1);
    }
}

static int write_array(const char *name, const qs_labels *labels, const uint16_t *labelling,
                       budget *limit, output *to)
{
    uint8_t head[NPY_HEAD];
    bool grid = labels->width > 0;
    const uint64_t shape[2] = {grid ? labels->height : labels->sites, labels->width};
    size_t count = grid ? (size_t)labels->width * labels->height : labels->sites;
    int32_t *numbers = budget_take(limit, name, count * sizeof *numbers);
    if (numbers == NULL) {
        return NO_RESOURCE;
    }
    for (size_t i = 0; i < count; i++) {
        bool masked = labels->mask != NULL && (labels->mask[i / 8] >> i % 8 & 1) == 0;
        numbers[i] = masked ? -1 : *labelling++;
    }
    size_t size = npy_head_write(shape, grid ? 2 : 1, head);
    (void)(output_write(to, head, size) && output_write(to, numbers, count * sizeof *numbers));
    return DONE;
}

static int write_picture(const char *name, const qs_labels *labels, const uint16_t *labelling,
                         bool png, budget *limit, output *to)
{
    picture made;
    TRY(meaning_picture(name, labels, labelling, limit, &made));
    return picture_write(&made, png, to);
}

int meaning_output_write(const char *name, const qs_labels *labels, const uint16_t *labelling,
                         const meaning_output *asked, budget *limit, output *to)
{
    flow_field field;
    switch (asked->format) {
    case MEANING_LIST: write_list(labels, labelling, to); return DONE;
    case MEANING_ARRAY: return write_array(name, labels, labelling, limit, to);
    case MEANING_FIELD:
        TRY(meaning_field(name, labels, labelling, limit, &field));
        return flow_write(&field, asked->png, to);
    case MEANING_PICTURE: break;
    }
    return write_picture(name, labels, labelling, asked->png, limit, to);
}
