#include <math.h>

#include "fields/flow_file.h"
#include "pictures/picture_library.h"
#include "pictures/picture_write.h"
#include "text/fail.h"

/* Hues of the wheel, in equal parts of the circle weighed as in the paper: 15 from red to yellow, 6
 * to green, 4 to cyan, 11 to blue, 13 to magenta, 6 back to red. */
enum { HUES = 6, WHEEL = 55 };
static const int parts[HUES] = {15, 6, 4, 11, 13, 6};
static const double hues[HUES + 1][3] = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 1, 1},
                                         {0, 0, 1}, {1, 0, 1}, {1, 0, 0}};

/* The colour at a place of the wheel, 0 .. WHEEL. */
static void hue_at(double place, double rgb[3])
{
    int hue = 0;
    while (hue + 1 < HUES && place >= parts[hue]) {
        place -= parts[hue++];
    }
    double part = place / parts[hue];
    for (int c = 0; c < 3; c++) {
        rgb[c] = hues[hue][c] * (1 - part) + hues[hue + 1][c] * part;
    }
}

static void colour_of(double dx, double dy, double longest, uint16_t samples[3])
{
    const double pi = 3.14159265358979323846;
    double length = longest > 0 ? hypot(dx, dy) / longest : 0, rgb[3];
    hue_at((atan2(-dy, -dx) / pi + 1) / 2 * WHEEL, rgb);
    for (int c = 0; c < 3; c++) {
        samples[c] = (uint16_t)lround(255 * (1 - length * (1 - rgb[c])));
    }
}

static double longest_of(const flow_field *field)
{
    double longest = 0;
    for (size_t i = 0; i < (size_t)field->width * field->height; i++) {
        /* fmax leaves NaN out. */
        longest =
            fmax(longest, hypot((double)field->vectors[2 * i], (double)field->vectors[2 * i + 1]));
    }
    return longest;
}

static void fill(const flow_field *shown, uint16_t *samples)
{
    double longest = longest_of(shown);
    for (size_t i = 0; i < (size_t)shown->width * shown->height; i++, samples += 3) {
        const float *vector = shown->vectors + 2 * i;
        if (isnan(vector[0])) {
            samples[0] = samples[1] = samples[2] = 0;
        } else {
            colour_of((double)vector[0], (double)vector[1], longest, samples);
        }
    }
}

int flow_colour_check(const char *path)
{
    if (path == NULL) {
        return DONE;
    }
    if (path_ends(path, ".png") && !picture_library_writes_png()) {
        return fail_usage("--color %s: this build writes only .ppm; for .png build qstereo with "
                          "OpenCV (make OPENCV=1)",
                          path);
    }
    return path_ends(path, ".png") || path_ends(path, ".ppm")
               ? DONE
               : fail_usage("--color %s: the name of a picture in colours ends in .png or .ppm",
                            path);
}

int flow_colour_write(const flow_field *shown, const char *path, output *to)
{
    picture made = {shown->width, shown->height, 3, 255, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(to->name);
    }
    fill(shown, made.samples);
    int status = picture_write(&made, path_ends(path, ".png"), to);
    picture_free(&made);
    return status;
}
