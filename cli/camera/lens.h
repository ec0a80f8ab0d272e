/* OpenCV's model of a camera: a pinhole and a lens whose distortion is a rational function of the
 * radius, tangential terms and thin prisms (Brown 1966; Weng et al. 1992; OpenCV, calib3d). */
#ifndef LENS_H
#define LENS_H

#include "camera/calibration.h"

typedef struct point {
    double x, y;
} point;

/* 3 x 3 matrices, row after row: a b, or a b^T. The result may not be one of the two. */
void matrix_product(const double a[9], const double b[9], double product[9]);
void matrix_transpose(const double a[9], double transposed[9]);

/* The pixel, in the picture that a camera takes, of a ray in the directions of the camera:
 * (x, y, 1). */
point lens_pixel(const camera *of, point ray);

/* The ray of a pixel of that picture: the inverse, in as many steps of a fixed point as OpenCV's
 * undistortPoints does by default. */
point lens_ray(const camera *of, point pixel);

/* A ray turned by a rotation, divided by its third coordinate. */
point ray_turned(const double rotation[9], point ray);

#endif
