#include "camera/depth.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "arrays/little_endian.h"
#include "pictures/picture_write.h"
#include "text/fail.h"

/* The depth of a pixel in metres: its distance along the optical axis of the rectified left camera.
 * Returns false if it has none. */
static bool depth_at(const depth_source *from, size_t x, size_t y, double *depth)
{
    int32_t value = from->map.values[y * from->map.width + x];
    double disparity = (double)value / from->map.scale + from->by.offset;
    if (value == QS_NO_DISPARITY || !(disparity > 0)) {
        return false;
    }
    *depth = from->by.focal * from->by.baseline / disparity * from->unit;
    return true;
}

depth_range depth_range_of(const depth_source *from)
{
    depth_range range = {0, 0, 0, 0};
    double depth;
    for (size_t y = 0; y < from->map.height; y++) {
        for (size_t x = 0; x < from->map.width; x++) {
            if (!depth_at(from, x, y, &depth)) {
                range.left_out++;
                continue;
            }
            bool first = range.points++ == 0;
            range.nearest = first ? depth : fmin(range.nearest, depth);
            range.farthest = first ? depth : fmax(range.farthest, depth);
        }
    }
    return range;
}

static uint16_t in_millimetres(double depth)
{
    double millimetres = floor(depth * 1000 + 0.5);
    if (millimetres > 65535) {
        return 0;
    }
    return millimetres < 1 ? 1 : (uint16_t)millimetres; /* 0 would be none */
}

int depth_picture_write(const depth_source *from, bool png, output *to)
{
    picture made = {from->map.width, from->map.height, 1, 65535, NULL};
    if (!picture_allocate(&made)) {
        return fail_memory(to->name);
    }
    for (size_t y = 0; y < made.height; y++) {
        for (size_t x = 0; x < made.width; x++) {
            double depth;
            made.samples[y * made.width + x] =
                depth_at(from, x, y, &depth) ? in_millimetres(depth) : 0;
        }
    }
    int status = picture_write(&made, png, to);
    picture_free(&made);
    return status;
}

static void write_point(const depth_source *from, size_t x, size_t y, double depth,
                        const colours *by, output *to)
{
    uint8_t bytes[3 * 4 + 3], *end = bytes;
    const stereo_geometry *cameras = &from->by;
    end = store_float(end, (float)(((double)x - cameras->x0) * depth / cameras->focal));
    end = store_float(end, (float)(((double)y - cameras->y0) * depth / cameras->focal_y));
    end = store_float(end, (float)depth);
    if (by != NULL) {
        const uint8_t *pixel = by->pixels + (y * by->width + x) * by->channels;
        for (unsigned c = 0; c < 3; c++) {
            *end++ = pixel[by->channels == 3 ? c : 0];
        }
    }
    (void)output_write(to, bytes, (size_t)(end - bytes));
}

void cloud_write(const depth_source *from, uint64_t points, const colours *by, output *to)
{
    char header[400];
    int size = snprintf(
        header, sizeof header,
        "ply\nformat binary_little_endian 1.0\n"
        "comment metres from the rectified left camera: x right, y down, z forward\n"
        "element vertex %" PRIu64 "\nproperty float x\nproperty float y\nproperty float z\n%s"
        "end_header\n",
        points,
        by != NULL ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "");
    (void)output_write(to, header, (size_t)size);
    for (size_t y = 0; y < from->map.height; y++) {
        for (size_t x = 0; x < from->map.width; x++) {
            double depth;
            if (depth_at(from, x, y, &depth)) {
                write_point(from, x, y, depth, by, to);
            }
        }
    }
}
