/* Depths and points from a disparity map and the geometry of its rectified cameras. Each function
 * that can fail returns an exit status and has printed why. */
#ifndef DEPTH_H
#define DEPTH_H

#include "camera/calibration.h"
#include "output.h"
#include "pictures/planes.h"

typedef struct depth_source {
    qs_map map;
    stereo_geometry by;
    double unit; /* of the calibration, in metres */
} depth_source;

typedef struct depth_range {
    uint64_t points; /* pixels with a depth */
    uint64_t left_out; /* pixels without one: no disparity, or one of infinity and beyond */
    double nearest, farthest; /* metres; 0 if there is no point */
} depth_range;

depth_range depth_range_of(const depth_source *from);

/* The largest depth that a picture of millimetres holds, in metres. */
#define DEPTH_PICTURE_MOST 65.535

/* Writes the depths as whole millimetres, a picture of 16 bits: 0 = no depth, or one beyond
 * DEPTH_PICTURE_MOST. Returns DONE or NO_RESOURCE. */
int depth_picture_write(const depth_source *from, bool png, output *to);

/* Writes the points as a binary PLY, little-endian: x to the right, y down and z forward from the
 * rectified left camera, in metres. job_commit reports refused bytes.
 *
 * points  how many there are
 * by      their colours, a picture of the size of the map; NULL = none */
void cloud_write(const depth_source *from, uint64_t points, const colours *by, output *to);

#endif
