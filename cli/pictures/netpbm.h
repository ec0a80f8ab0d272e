/* The Netpbm formats: PBM, PGM, PPM and PAM (whole numbers) and PFM (floats). They work on files
 * in memory and allocate what they return with malloc. */
#ifndef NETPBM_H
#define NETPBM_H

#include "files.h"
#include "pictures/picture.h"

/* PBM, PGM, PPM, in ASCII and binary, and PAM, of up to 16 bits. Encoded are PGM and PPM. */
bool pnm_is(const file_bytes *file);
bool pnm_size(const file_bytes *file, picture *stated); /* false = it is damaged */
picture_status pnm_decode(const file_bytes *file, picture *decoded, char reason[REASON_SIZE]);
picture_status pnm_encode(const picture *encoded, file_bytes *file);

/* The same in parts, for a picture that is never whole in memory: its header, without samples, and
 * then rows. They are strings of bytes of at most HEADER_SIZE, and of 2 bytes a sample. Return how
 * many bytes that is. */
enum { HEADER_SIZE = 64 };
size_t pnm_header(const picture *encoded, uint8_t header[HEADER_SIZE]);
size_t pnm_pack(const uint16_t *samples, size_t count, uint32_t maxval, uint8_t *bytes);

/* PFM with one value per pixel. */
bool pfm_is(const file_bytes *file);
picture_status pfm_decode(const file_bytes *file, float_picture *decoded, char reason[REASON_SIZE]);
picture_status pfm_encode(const float_picture *encoded, file_bytes *file);

/* The same in parts: the rows follow from the bottom, 4 bytes a value. */
size_t pfm_header(size_t width, size_t height, uint8_t header[HEADER_SIZE]);
size_t pfm_pack(const float *values, size_t count, uint8_t *bytes);

#endif
