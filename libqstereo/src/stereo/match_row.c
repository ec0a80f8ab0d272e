#include "match_row.h"

#include <string.h>

#include "../base/simd.h"

qs_match_row qs_match_row_take(qs_arena *arena, const qs_match_needs *needs, size_t width,
                               size_t pad, size_t behind)
{
    size_t length = pad + width + behind;
    qs_match_row row = {.pad = pad, .length = length};
    row.grey = qs_arena_take(arena, length, 1);
    if (needs->range) {
        row.low = qs_arena_take(arena, length, sizeof *row.low);
        row.high = qs_arena_take(arena, length, sizeof *row.high);
    }
    for (int i = 0; needs->census && i < QS_CENSUS_BYTES; i++) {
        row.census[i] = qs_arena_take(arena, length, 1);
    }
    row.words = needs->census ? qs_arena_take(arena, length, sizeof *row.words) : NULL;
    for (int i = 0; needs->census && i < QS_CENSUS_ROWS; i++) {
        row.around[i] = qs_arena_take(arena, width + 2 * (size_t)QS_CENSUS_REACH, 1);
    }
    return row;
}

static void read_samples(const uint8_t *restrict pixels, size_t width, bool between,
                         uint8_t *restrict samples)
{
    if (!between) {
        memcpy(samples, pixels, width);
        return;
    }
    samples[0] = pixels[0];
    for (size_t x = 1; x < width; x++) {
        samples[x] = (uint8_t)((pixels[x - 1] + pixels[x] + 1) / 2);
    }
}

/* The range of each doubled sample. Outside the row its last sample counts. */
static void read_ranges(const uint8_t *restrict grey, size_t width, int16_t *restrict low,
                        int16_t *restrict high)
{
    for (size_t x = 0; x < width; x++) {
        int16_t own = (int16_t)(2 * grey[x]);
        int16_t before = (int16_t)(grey[x] + grey[x > 0 ? x - 1 : 0]);
        int16_t after = (int16_t)(grey[x] + grey[x + 1 < width ? x + 1 : x]);
        int16_t least = before < after ? before : after, most = before < after ? after : before;
        low[x] = least < own ? least : own;
        high[x] = most > own ? most : own;
    }
}

/* Eight bits of the census of each sample: whether others are less than it. */
QS_KERNEL void compare_eight(const uint8_t *const others[8], const uint8_t *restrict centre,
                             size_t width, uint8_t *restrict census)
{
    const uint8_t *restrict a = others[0], *restrict b = others[1], *restrict c = others[2],
                            *restrict d = others[3], *restrict e = others[4],
                            *restrict f = others[5], *restrict g = others[6],
                            *restrict h = others[7];
    for (size_t x = 0; x < width; x++) {
        uint8_t at = centre[x];
        census[x] = (uint8_t)((a[x] < at ? 1 : 0) | (b[x] < at ? 2 : 0) | (c[x] < at ? 4 : 0) |
                              (d[x] < at ? 8 : 0) | (e[x] < at ? 16 : 0) | (f[x] < at ? 32 : 0) |
                              (g[x] < at ? 64 : 0) | (h[x] < at ? 128 : 0));
    }
}

static void plain_eight(const uint8_t *const others[8], const uint8_t *centre, size_t width,
                        uint8_t *census)
{
    compare_eight(others, centre, width, census);
}

QS_AVX2 static void wide_eight(const uint8_t *const others[8], const uint8_t *centre, size_t width,
                               uint8_t *census)
{
    compare_eight(others, centre, width, census);
}

/* The bits of a window in raster order, without its centre. Behind the last one the centre itself
 * stands for more: their bits are 0. */
static void read_census(qs_match_row *row, const qs_match_needs *needs, size_t width)
{
    enum { BITS = 8 };
    int across = (int)needs->width / 2, down = (int)needs->height / 2;
    const uint8_t *centre = row->around[QS_CENSUS_REACH] + QS_CENSUS_REACH;
    const uint8_t *others[QS_CENSUS_BYTES * BITS];
    size_t count = 0;
    for (int dy = -down; dy <= down; dy++) {
        for (int dx = -across; dx <= across; dx++) {
            if (dx != 0 || dy != 0) {
                others[count++] = row->around[QS_CENSUS_REACH + dy] + QS_CENSUS_REACH + dx;
            }
        }
    }
    while (count < QS_CENSUS_BYTES * BITS) {
        others[count++] = centre;
    }
    for (int i = 0; i < QS_CENSUS_BYTES; i++) {
        uint8_t *census = row->census[i] + row->pad;
        memset(row->census[i], 0, row->pad);
        memset(census + width, 0, row->length - row->pad - width);
        if (needs->wide) {
            wide_eight(others + i * BITS, centre, width, census);
        } else {
            plain_eight(others + i * BITS, centre, width, census);
        }
    }
}

/* A row for the windows; of those outside the picture the nearest one. */
static void read_other(const qs_image *image, size_t y, bool between, uint8_t *to)
{
    size_t width = image->width;
    uint8_t *samples = to + QS_CENSUS_REACH;
    read_samples(image->pixels + y * image->stride, width, between, samples);
    memset(to, samples[0], QS_CENSUS_REACH);
    memset(samples + width, samples[width - 1], QS_CENSUS_REACH);
}

/* The rows about row y. If they follow those that are there, only the last one is new. */
static void read_around(qs_match_row *row, const qs_image *image, size_t y, bool between)
{
    size_t last = image->height - 1;
    bool follows = row->next == y && y > 0;
    uint8_t *first = row->around[0];
    if (follows) {
        memmove(row->around, row->around + 1, (QS_CENSUS_ROWS - 1) * sizeof *row->around);
        row->around[QS_CENSUS_ROWS - 1] = first;
    }
    for (size_t i = follows ? QS_CENSUS_ROWS - 1 : 0; i < QS_CENSUS_ROWS; i++) {
        size_t at = y + i > QS_CENSUS_REACH ? y + i - QS_CENSUS_REACH : 0;
        read_other(image, at < last ? at : last, between, row->around[i]);
    }
    row->next = y + 1;
}

void qs_match_row_pack(qs_match_row *row)
{
    const uint8_t *restrict a = row->census[0], *restrict b = row->census[1],
                            *restrict c = row->census[2], *restrict d = row->census[3],
                            *restrict e = row->census[4], *restrict f = row->census[5];
    uint64_t *restrict words = row->words;
    for (size_t x = 0; words && x < row->length; x++) {
        words[x] = (uint64_t)a[x] | (uint64_t)b[x] << 8 | (uint64_t)c[x] << 16 |
                   (uint64_t)d[x] << 24 | (uint64_t)e[x] << 32 | (uint64_t)f[x] << 40;
    }
}

void qs_match_row_read(qs_match_row *row, const qs_match_needs *needs, const qs_image *image,
                       size_t y, bool between)
{
    uint8_t *grey = row->grey + row->pad;
    memset(row->grey, 0, row->length);
    read_samples(image->pixels + y * image->stride, image->width, between, grey);
    if (needs->range) {
        memset(row->low, 0, row->length * sizeof *row->low);
        memset(row->high, 0, row->length * sizeof *row->high);
        read_ranges(grey, image->width, row->low + row->pad, row->high + row->pad);
    }
    if (needs->census) {
        read_around(row, image, y, between);
        read_census(row, needs, image->width);
    }
}
