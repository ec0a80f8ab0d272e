/* SHA-256 (FIPS 180-4). A samples file names the problem that it answers by the
 * digest of the problem's file. */
#ifndef QSTEREO_DIGEST_H
#define QSTEREO_DIGEST_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define QS_DIGEST_SIZE 32 /* bytes */

/* The SHA-256 of `size` bytes. */
void qs_digest(const void *bytes, size_t size, uint8_t digest[QS_DIGEST_SIZE]);

#ifdef __cplusplus
}
#endif

#endif
