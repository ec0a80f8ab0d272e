/* CRC-32C (Castagnoli), the check sum of every chunk. */
#ifndef QS_CRC32C_H
#define QS_CRC32C_H

#include <stddef.h>
#include <stdint.h>

/* The CRC of bytes that follow others whose CRC is `crc` (0 = none). */
typedef uint32_t qs_crc(uint32_t crc, const uint8_t *bytes, size_t size);

/* With tables, on any machine. */
uint32_t qs_crc32c_portable(uint32_t crc, const uint8_t *bytes, size_t size);

/* The fastest that this machine has. Ask once for each file: on a virtual machine, which intercepts
 * the instruction that identifies the processor, an answer takes up to some 15 microseconds. */
qs_crc *qs_crc32c_fastest(void);

#endif
