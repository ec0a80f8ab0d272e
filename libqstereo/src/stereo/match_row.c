#include "match_row.h"

#include <string.h>

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

static void add_bit(const uint8_t *restrict other, const uint8_t *restrict centre, size_t width,
                    unsigned bit, uint8_t *restrict census)
{
    uint8_t mask = (uint8_t)(1u << bit);
    for (size_t x = 0; x < width; x++) {
        census[x] |= other[x] < centre[x] ? mask : 0;
    }
}

/* The bits of a window in raster order, without its centre. */
static void read_census(qs_match_row *row, const qs_match_needs *needs, size_t width)
{
    int across = (int)needs->width / 2, down = (int)needs->height / 2;
    unsigned bit = 0;
    const uint8_t *centre = row->around[QS_CENSUS_REACH] + QS_CENSUS_REACH;
    for (int i = 0; i < QS_CENSUS_BYTES; i++) {
        memset(row->census[i], 0, row->length);
    }
    for (int dy = -down; dy <= down; dy++) {
        for (int dx = -across; dx <= across; dx++) {
            if (dx == 0 && dy == 0) {
                continue;
            }
            add_bit(row->around[QS_CENSUS_REACH + dy] + QS_CENSUS_REACH + dx, centre, width,
                    bit % 8, row->census[bit / 8] + row->pad);
            bit++;
        }
    }
}

/* The rows about row y, with the nearest sample of the picture outside it. */
static void read_around(qs_match_row *row, const qs_image *image, size_t y, bool between)
{
    size_t width = image->width, last = image->height - 1;
    for (size_t i = 0; i < QS_CENSUS_ROWS; i++) {
        size_t at = y + i > QS_CENSUS_REACH ? y + i - QS_CENSUS_REACH : 0;
        uint8_t *samples = row->around[i] + QS_CENSUS_REACH;
        at = at < last ? at : last;
        read_samples(image->pixels + at * image->stride, width, between, samples);
        memset(row->around[i], samples[0], QS_CENSUS_REACH);
        memset(samples + width, samples[width - 1], QS_CENSUS_REACH);
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
