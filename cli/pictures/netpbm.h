/* The Netpbm formats: PBM, PGM, PPM and PAM (whole numbers) and PFM (floats). They work on files
 * in memory and allocate what they return with malloc. */
#ifndef NETPBM_H
#define NETPBM_H

#include "files.h"
#include "pictures/picture.h"

/* PBM, PGM, PPM, in ASCII and binary, and PAM, of up to 16 bits. Encoded are PGM and PPM. */
bool pnm_is(const file_bytes *file);
picture_status pnm_decode(const file_bytes *file, picture *decoded, char reason[REASON_SIZE]);
picture_status pnm_encode(const picture *encoded, file_bytes *file);

/* PFM with one value per pixel. */
bool pfm_is(const file_bytes *file);
picture_status pfm_decode(const file_bytes *file, float_picture *decoded, char reason[REASON_SIZE]);
picture_status pfm_encode(const float_picture *encoded, file_bytes *file);

#endif
