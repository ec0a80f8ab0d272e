#include "meaning_output.h"

#include <string.h>

#include "arrays/npy.h"
#include "makers/kept_list.h"
#include "pictures/picture_library.h"
#include "pictures/picture_write.h"
#include "text/fail.h"

/* What labels are called, and how the names of their files may end. */
typedef struct forms {
    const char *labels, *list;
    const char *endings[5];
} forms;

static const forms no_grid = {"numbers of a graph", ".npy", {".npy"}};
static const forms forms_of[QS_MEANING_KINDS] = {
    [QS_MEANS_DISPARITY] = {"disparities",
                            ".png, .pgm, .pfm or .npy",
                            {".png", ".pgm", ".pfm", ".npy"}},
    [QS_MEANS_NUMBER] = {"numbers", ".npy, .png or .pgm", {".npy", ".png", ".pgm"}},
    [QS_MEANS_GREY] = {"greys", ".png, .pgm or .npy", {".png", ".pgm", ".npy"}},
    [QS_MEANS_CLASS] = {"classes", ".png, .pgm or .npy", {".png", ".pgm", ".npy"}},
    [QS_MEANS_DISPLACEMENT] = {"displacements", ".flo, .png or .npy", {".flo", ".png", ".npy"}},
    [QS_MEANS_KEEP] = {"boxes to keep or drop", ".csv or .npy", {".csv", ".npy"}},
};

int meaning_ending_check(const char *name, const qs_labels *labels, const char *path)
{
    const forms *own = &forms_of[labels->meaning.kind];
    if (labels->meaning.kind == QS_MEANS_NUMBER && labels->width == 0) {
        own = &no_grid;
    }
    for (size_t i = 0; own->endings[i] != NULL; i++) {
        if (path_ends(path, own->endings[i])) {
            return DONE;
        }
    }
    bool straight = output_is_straight(path) ||
                    (labels->meaning.kind == QS_MEANS_DISPARITY && strcmp(path, "pfm:-") == 0);
    return straight && own != &no_grid
               ? DONE
               : fail_usage("-o %s: the labels of %s are %s: choose a name that ends in %s", path,
                            name, own->labels, own->list);
}

int meaning_output_read(const char *name, const qs_labels *labels, const char *path,
                        meaning_output *asked)
{
    memset(asked, 0, sizeof *asked);
    TRY(meaning_ending_check(name, labels, path));
    if (path_ends(path, ".npy")) {
        asked->format = MEANING_ARRAY;
        return DONE;
    }
    switch (labels->meaning.kind) {
    case QS_MEANS_KEEP: asked->format = MEANING_LIST; return DONE;
    case QS_MEANS_DISPLACEMENT:
        asked->format = MEANING_FIELD;
        return flow_format_read(path, &asked->png);
    case QS_MEANS_NUMBER:
    case QS_MEANS_DISPARITY:
    case QS_MEANS_GREY:
    case QS_MEANS_CLASS: break;
    }
    asked->format = MEANING_PICTURE;
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
    case MEANING_LIST:
        if (asked->boxes != NULL) {
            boxes_write(asked->boxes, labelling, to);
        } else {
            kept_list_write(labelling, labels->sites, to);
        }
        return DONE;
    case MEANING_ARRAY: return write_array(name, labels, labelling, limit, to);
    case MEANING_FIELD:
        TRY(meaning_field(name, labels, labelling, limit, &field));
        return flow_write(&field, asked->png, to);
    case MEANING_PICTURE: break;
    }
    return write_picture(name, labels, labelling, asked->png, limit, to);
}
