/* Pictures as a rectified pair of cameras would have taken them. Each function that can fail
 * returns an exit status and has printed why. */
#ifndef RECTIFIER_H
#define RECTIFIER_H

#include "camera/calibration.h"
#include "pictures/picture.h"

/* Where a pixel of a rectified picture lies in the camera's, in steps of 1/256 pixel: the finest
 * with which a sum of samples of 16 bits has 32 bits. */
enum { PLACE_STEPS = 256 };
typedef struct place {
    int32_t x, y;
} place;

/* Made once, and used for every picture of a sequence. */
typedef struct rectifier {
    place *places[2]; /* of the left and the right picture, row after row; the budget owns them */
    uint32_t width, height;
} rectifier;

/* Bytes of the tables for pictures of that size. */
uint64_t rectifier_bytes(uint64_t width, uint64_t height);

/* Makes the tables of a complete calibration that is not rectified. Returns DONE or NO_RESOURCE. */
int rectifier_make(const calibration *from, budget *limit, rectifier *made);

/* Samples a picture of the left (0) or right (1) camera between its pixels, in two directions;
 * black lies around it. picture_free frees the result. Returns DONE or NO_RESOURCE. */
int rectifier_apply(const rectifier *by, unsigned side, const picture *from, const char *name,
                    picture *to);

#endif
