/* Colours for people: small disparities blue, large ones red, no value black. */
#ifndef COLOUR_H
#define COLOUR_H

#include <stdint.h>

/* The colour of `value` on a scale that ends at `most` (at least `value`). */
void colour_of(uint32_t value, uint32_t most, uint16_t rgb[3]);

#endif
