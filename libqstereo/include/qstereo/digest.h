/* SHA-256 (FIPS 180-4): the name of a problem in the samples that answer it. */
#ifndef QSTEREO_DIGEST_H
#define QSTEREO_DIGEST_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define QS_DIGEST_SIZE 32

/* SHA-256 of `size` bytes. */
void qs_digest(const void *bytes, size_t size, uint8_t digest[QS_DIGEST_SIZE]);

#ifdef __cplusplus
}
#endif

#endif
