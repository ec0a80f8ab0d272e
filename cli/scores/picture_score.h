/* Grey pictures beside the truth. */
#ifndef PICTURE_SCORE_H
#define PICTURE_SCORE_H

#include "files.h"
#include "qstereo.h"

typedef struct picture_score {
    uint64_t pixels;
    double mse, psnr; /* squared grey levels; decibel, infinite if the pictures are equal */
    bool has_ssim;
    double ssim;
    uint64_t hole_pixels; /* 0 = no hole was asked for */
    double hole_psnr;
} picture_score;

/* Compares two pictures of one size.
 *
 *     psnr = 10 log10(255^2 / mse)
 *     ssim: Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to
 *     structural similarity", IEEE TIP 13(4), 2004: the mean over all places of a Gaussian window
 *     of 11 x 11 pixels, sigma 1.5, that lie within the picture; none if it is smaller
 *
 * hole  of the same size, not 0 = the pixel is in the hole; NULL = none. */
void picture_score_find(const qs_image *map, const qs_image *truth, const uint8_t *hole,
                        picture_score *found);

/* Print the scores: keys of JSON, and lines for people. */
void picture_score_json(const picture_score *shown);
void picture_score_print(const picture_score *shown);

#endif
