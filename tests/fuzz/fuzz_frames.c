/* What reads frames and cameras: streams of Y4M, PGM and PPM, OpenCV's calibrations, and the words
 * that say how pictures are matched. The first byte says which. */
#define _XOPEN_SOURCE 700

#include <math.h>
#include <string.h>

#include "camera/numbered.h"
#include "camera/storage.h"
#include "text/fail.h"
#include "fuzz.h"
#include "matching_read.h"
#include "pictures/picture_stream.h"

enum { LIMIT = 1 << 20, FRAMES = 64, NUMBER = 207 };

static void read_stream(uint8_t *bytes, size_t size)
{
    budget limit = budget_of(1);
    picture_stream from = {.file = fmemopen(bytes, size, "rb"), .name = "stream"};
    bool ended = false;
    for (int i = 0; from.file != NULL && !ended && i < FRAMES; i++) {
        picture read = {.samples = NULL};
        if (stream_next(&from, from.name, &limit, &read, &ended) != DONE || ended) {
            break;
        }
        size_t count = read.width * read.height * read.channels;
        PROMISE(count > 0 && count <= LIMIT);
        for (size_t k = 0; k < count; k++) {
            PROMISE(read.samples[k] <= read.maxval);
        }
        picture_free(&read);
    }
    stream_close(&from);
}

static void read_storage(uint8_t *bytes, size_t size)
{
    static const char *const names[] = {"K1", "D1", "R", "T", "P2", "cameraMatrix1", "image_width"};
    const file_bytes file = {bytes, size};
    const storage in = storage_of(&file);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        matrix found;
        if (storage_find(&in, names[i], &found) == STORED) {
            PROMISE(found.rows * found.columns <= MATRIX_MAX);
            for (size_t k = 0; k < found.rows * found.columns; k++) {
                PROMISE(isfinite(found.values[k]));
            }
        }
    }
}

static void read_matching(const char *text)
{
    qs_matching matching = {.parts = 1};
    if (cost_read(text, &matching) == DONE) {
        uint32_t most = qs_matching_most(&matching);
        PROMISE(most >= 1 && most <= UINT16_MAX && matching.term_count <= QS_MATCH_TERMS);
        border_read("keep", &matching);
    }
    if (disparity_range_read(text, "1", &matching) == DONE) {
        PROMISE(matching.disparity_min <= matching.disparity_max);
        PROMISE((int64_t)matching.disparity_max - matching.disparity_min < QS_LABELS_MAX);
    }
    if (contrast_read(text, &matching) == DONE) {
        PROMISE(matching.contrast_below <= 256);
    }
}

/* A name with a number in it keeps what stands around the number. */
static void read_numbered(const char *text)
{
    budget limit = budget_of(1);
    numbered names;
    if (!numbered_read(text, &names)) {
        return;
    }
    char *name = numbered_name(&names, NUMBER, &limit);
    PROMISE(name != NULL && strlen(name) >= names.before + 3 + strlen(names.after));
    PROMISE(memcmp(name, text, names.before) == 0);
    PROMISE(strcmp(name + strlen(name) - strlen(names.after), names.after) == 0);
    budget_free(&limit);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 2) {
        return 0;
    }
    char *text = malloc(size);
    memcpy(text, data + 1, size - 1);
    text[size - 1] = '\0';
    switch (data[0] % 4) {
    case 0: read_stream((uint8_t *)text, size - 1); break;
    case 1: read_storage((uint8_t *)text, size - 1); break;
    case 2: read_matching(text); break;
    default: read_numbered(text);
    }
    free(text);
    return 0;
}
