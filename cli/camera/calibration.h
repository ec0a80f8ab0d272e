/* A calibrated pair of cameras, from OpenCV's own files or from Middlebury's calib.txt. Each
 * function that can fail returns an exit status and has printed why. */
#ifndef CALIBRATION_H
#define CALIBRATION_H

#include "command.h"
#include "files.h"

/* A row for a table of options. */
#define CALIBRATION_OPTION(required, help) {"calibration", 0, required, "FILE", NULL, help}
#define CALIBRATION_FILES                                                                          \
    "calibration of the two cameras: OpenCV's (YAML or XML) or Middlebury's calib.txt; give it "   \
    "twice if it is in two files"

/* k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4: those that a file does not have are 0. */
enum { DISTORTIONS = 12 };

/* Matrices row after row, in pixels and in the unit of the calibration. */
typedef struct camera {
    double matrix[9]; /* K: from a ray to a pixel of the picture that the camera took */
    double distortion[DISTORTIONS]; /* OpenCV's model of lenses */
    double rotation[9]; /* R1, R2: from the camera to its rectified one */
    double
        projection[12]; /* P1, P2: from the rectified camera to a pixel of the rectified picture */
} camera;

typedef struct calibration {
    const char *name; /* of the first file, for messages */
    camera cameras[2]; /* left and right */
    double rotation[9], translation[3]; /* R and T, from the left camera to the right one */
    bool has_projections; /* the files say R1, R2, P1 and P2 */
    bool is_rectified; /* its pictures are rectified already: it has projections alone */
    uint32_t width, height; /* of the pictures; 0 = the files do not say it */
    uint32_t labels; /* disparities 0 .. labels - 1 are to be searched; 0 = it is not said */
} calibration;

/* Reads the files that --calibration names, one or two; `index` is that of the option in the
 * command's table. Returns DONE, BAD_USAGE, BAD_INPUT or NO_RESOURCE. */
int calibration_read(const job *at, size_t index, budget *limit, calibration *read);

/* Makes a calibration ready for pictures of a size: checks that it is of that size, and computes
 * R1, R2, P1 and P2 if the files do not say them. Returns DONE or BAD_INPUT. */
int calibration_complete(calibration *of, const char *picture_name, size_t width, size_t height);

/* What turns disparities d of the rectified left picture into points: Z = focal * baseline /
 * (d + offset), X = (x - x0) * Z / focal, Y = (y - y0) * Z / focal_y. */
typedef struct stereo_geometry {
    double focal, focal_y, x0, y0, offset; /* pixels */
    double baseline; /* in the unit of the calibration */
} stereo_geometry;

stereo_geometry calibration_geometry(const calibration *of);

#endif
