/* Rectification: two rotations and projections after which a point lies on the same row of both
 * pictures. */
#ifndef RECTIFICATION_H
#define RECTIFICATION_H

#include "camera/calibration.h"

/* Finds R1, R2, P1 and P2 from R, T and the size of the pictures, as OpenCV's stereoRectify does
 * with CALIB_ZERO_DISPARITY and alpha = 0: both cameras turn half of the way, the principal points
 * are the same, and the pictures are enlarged until no pixel of them lies outside of what the
 * cameras saw. (A. Fusiello et al., "A compact algorithm for rectification of stereo pairs", 2000;
 * J. Bouguet's toolbox.) Returns DONE, or BAD_INPUT if the cameras do not stand side by side. */
int rectification_find(calibration *of);

#endif
