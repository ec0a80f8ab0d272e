#include "colour.h"

/* Straight lines between nine points of a map after Google's Turbo, in integers, so that every
 * machine draws the same.
 */
void colour_of(uint32_t value, uint32_t most, uint16_t rgb[3])
{
    enum { STEPS = 8, PART = 256 };
    static const uint8_t points[STEPS + 1][3] = {{48, 18, 59},   {70, 107, 227}, {40, 187, 236},
                                                 {49, 242, 153}, {162, 252, 60}, {237, 208, 58},
                                                 {251, 128, 34}, {210, 49, 5},   {122, 4, 3}};
    uint64_t place = most > 0 ? (uint64_t)value * STEPS * PART / most : 0;
    unsigned step = (unsigned)(place / PART), part = (unsigned)(place % PART);
    for (unsigned c = 0; c < 3; c++) {
        unsigned from = points[step][c], to = points[step + (part > 0)][c];
        rgb[c] = (uint16_t)((from * (PART - part) + to * part + PART / 2) / PART);
    }
}
