/* CRC-32C (Castagnoli), the check of every chunk. */
#ifndef QS_CRC32C_H
#define QS_CRC32C_H

#include <stddef.h>
#include <stdint.h>

/* The CRC of bytes that follow others whose CRC is `crc` (0 = none). */
typedef uint32_t qs_crc(uint32_t crc, const uint8_t *bytes, size_t size);

/* By tables, on any machine. */
uint32_t qs_crc32c_portable(uint32_t crc, const uint8_t *bytes, size_t size);

/* The fastest that this machine has. Asking takes up to some 15 microseconds on a virtual machine
 * (the processor's identification is intercepted there): ask once a file. */
qs_crc *qs_crc32c_fastest(void);

#endif
