#include "pictures/colour_map.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { STEPS = 32, PART = 256 };

/* Points of Google's Turbo (A. Mikhailov, 2019) and of matplotlib's viridis (N. Smith and S. van
 * der Walt, 2015), in equal steps. */
static const uint8_t points[][STEPS + 1][3] = {
    [PALETTE_TURBO] = {{48, 18, 59},   {57, 42, 115},  {64, 64, 161},   {68, 86, 199},
                       {70, 107, 227}, {70, 127, 246}, {66, 147, 255},  {55, 167, 250},
                       {41, 187, 236}, {29, 205, 216}, {24, 220, 195},  {30, 232, 176},
                       {49, 242, 153}, {76, 249, 126}, {107, 253, 100}, {138, 255, 77},
                       {163, 253, 60}, {184, 247, 53}, {204, 237, 52},  {222, 224, 55},
                       {237, 208, 58}, {248, 192, 58}, {253, 174, 53},  {254, 152, 44},
                       {251, 128, 34}, {245, 104, 23}, {236, 82, 15},   {224, 64, 9},
                       {210, 49, 5},   {192, 35, 2},   {172, 23, 1},    {149, 13, 1},
                       {122, 4, 3}},
    [PALETTE_VIRIDIS] = {{68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},
                         {71, 45, 123},  {69, 54, 129},  {66, 64, 134},  {63, 73, 137},
                         {59, 82, 139},  {55, 90, 141},  {51, 99, 141},  {47, 106, 142},
                         {44, 114, 142}, {41, 122, 142}, {38, 129, 142}, {35, 137, 142},
                         {33, 144, 140}, {31, 152, 139}, {31, 159, 136}, {33, 166, 133},
                         {40, 174, 128}, {49, 181, 123}, {62, 188, 116}, {76, 194, 108},
                         {93, 201, 99},  {110, 206, 88}, {130, 211, 76}, {150, 216, 63},
                         {171, 220, 50}, {192, 223, 36}, {213, 226, 26}, {234, 229, 26},
                         {253, 231, 37}},
};

/* Straight lines between the points, in integers, so that every machine draws the same. */
void colour_of_value(palette by, uint32_t value, uint32_t most, uint16_t rgb[3])
{
    uint64_t place = most > 0 ? (uint64_t)value * STEPS * PART / most : 0;
    unsigned step = (unsigned)(place / PART), part = (unsigned)(place % PART);
    for (unsigned c = 0; c < 3; c++) {
        unsigned from = points[by][step][c], to = points[by][step + (part > 0)][c];
        rgb[c] = (uint16_t)((from * (PART - part) + to * part + PART / 2) / PART);
    }
}

/* From left to right: a gap, the colours, a tick, a gap, and up to 5 digits. */
enum { GAP = 6, COLOURS = 12, TICK = 4, DOT = 2, DIGIT_DOTS = 3, DIGIT_ROWS = 5, DIGITS = 5 };

static void paint(uint16_t *samples, int from, int to, const uint16_t rgb[3])
{
    for (int x = from; x < to && x < BAR_WIDTH; x++) {
        memcpy(samples + 3 * x, rgb, 3 * sizeof *rgb);
    }
}

/* One row of dots of a number. */
static void draw_digits(int32_t number, int row, uint16_t *samples)
{
    static const uint16_t white[3] = {255, 255, 255};
    /* 5 rows of 3 dots, the upper left one first. */
    static const uint16_t shapes[10] = {0x7B6F, 0x2C97, 0x73E7, 0x73CF, 0x5BC9,
                                        0x79CF, 0x79EF, 0x7249, 0x7BEF, 0x7BCF};
    static const uint16_t minus = 0x01C0;
    char text[12];
    (void)snprintf(text, sizeof text, "%" PRId32, number);
    for (int i = 0; i < DIGITS && text[i] != '\0'; i++) {
        unsigned shape = text[i] == '-' ? minus : shapes[text[i] - '0'];
        unsigned dots = shape >> DIGIT_DOTS * (DIGIT_ROWS - 1 - row);
        for (int dot = 0; dot < DIGIT_DOTS; dot++) {
            int x = GAP + COLOURS + TICK + 2 + (i * (DIGIT_DOTS + 1) + dot) * DOT;
            if (dots >> (DIGIT_DOTS - 1 - dot) & 1) {
                paint(samples, x, x + DOT, white);
            }
        }
    }
}

/* A tick at a number of pixels, and the number beside it, kept inside of the picture. */
static void draw_label(const colour_bar *of, int32_t pixels, int64_t y, uint16_t *samples)
{
    static const uint16_t white[3] = {255, 255, 255};
    int64_t span = (int64_t)of->most - of->least, above = (int64_t)pixels * of->unit - of->least;
    int64_t bottom = (int64_t)of->height - 1, tall = DIGIT_ROWS * DOT;
    int64_t at = span > 0 ? bottom - above * bottom / span : bottom;
    int64_t top = at - tall / 2;
    top = top + tall > bottom + 1 ? bottom + 1 - tall : top;
    top = top < 0 ? 0 : top;
    if (y == at) {
        paint(samples, GAP + COLOURS, GAP + COLOURS + TICK, white);
    }
    if (y >= top && y < top + tall) {
        draw_digits(pixels, (int)((y - top) / DOT), samples);
    }
}

/* The least whole number of units that is not below a value. */
static int64_t whole_up(int64_t value, int64_t unit)
{
    return value > 0 ? (value + unit - 1) / unit : -(-value / unit);
}

void colour_bar_row(const colour_bar *of, uint32_t y, uint16_t *samples)
{
    enum { LABELS = 4, LABEL_HEIGHT = 24 };
    uint16_t rgb[3];
    int64_t unit = of->unit, first = whole_up(of->least, unit), last = -whole_up(-of->most, unit);
    int64_t span = last - first, labels = of->height / LABEL_HEIGHT;
    memset(samples, 0, 3 * BAR_WIDTH * sizeof *samples);
    colour_of_value(of->by, of->height - 1 - y, of->height - 1, rgb);
    paint(samples, GAP, GAP + COLOURS, rgb);
    labels = labels > LABELS ? LABELS : labels;
    labels = labels > span ? span : labels;
    for (int64_t i = 0; i <= labels; i++) { /* none if no whole pixel lies between the ends */
        draw_label(of, (int32_t)(first + (labels > 0 ? span * i / labels : 0)), y, samples);
    }
}
