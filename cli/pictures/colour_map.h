/* The colours of a map, and a bar beside it that says what they mean. */
#ifndef COLOUR_MAP_H
#define COLOUR_MAP_H

#include <stddef.h>
#include <stdint.h>

typedef enum palette { PALETTE_TURBO, PALETTE_VIRIDIS } palette;

/* The colour of `value` on a scale from 0 to `most`. */
void colour_of_value(palette by, uint32_t value, uint32_t most, uint16_t rgb[3]);

/* The columns that the bar takes on the right of a picture. */
enum { BAR_WIDTH = 68 };

typedef struct colour_bar {
    palette by;
    int32_t least, most; /* the values at its lower and its upper end */
    uint32_t unit; /* of them are one pixel; the numbers are whole pixels */
    uint32_t height; /* of the picture */
} colour_bar;

/* Draws row y of the bar: 3 * BAR_WIDTH samples. */
void colour_bar_row(const colour_bar *of, uint32_t y, uint16_t *samples);

#endif
