/* Little-endian loads and stores for any alignment and any byte order of the machine. Compilers
 * make one instruction of each. */
#ifndef QS_BYTES_H
#define QS_BYTES_H

#include <stddef.h>
#include <stdint.h>

static inline uint32_t qs_load_u16(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8;
}

static inline uint32_t qs_load_u32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t qs_load_u64(const uint8_t *p)
{
    return qs_load_u32(p) | (uint64_t)qs_load_u32(p + 4) << 32;
}

static inline int32_t qs_load_i32(const uint8_t *p)
{
    return (int32_t)qs_load_u32(p);
}

static inline int64_t qs_load_i64(const uint8_t *p)
{
    return (int64_t)qs_load_u64(p);
}

/* An unsigned integer of 1, 2, 4 or 8 bytes. */
static inline uint64_t qs_load_unsigned(const uint8_t *p, unsigned bytes)
{
    switch (bytes) {
    case 1: return p[0];
    case 2: return qs_load_u16(p);
    case 4: return qs_load_u32(p);
    default: return qs_load_u64(p);
    }
}

/* A signed integer of 1, 2 or 4 bytes. */
static inline int32_t qs_load_signed(const uint8_t *p, unsigned bytes)
{
    switch (bytes) {
    case 1: return (int8_t)p[0];
    case 2: return (int16_t)qs_load_u16(p);
    default: return qs_load_i32(p);
    }
}

static inline void qs_store_u16(uint8_t *p, uint32_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
}

static inline void qs_store_u32(uint8_t *p, uint32_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
    p[2] = (uint8_t)(value >> 16);
    p[3] = (uint8_t)(value >> 24);
}

static inline void qs_store_u64(uint8_t *p, uint64_t value)
{
    qs_store_u32(p, (uint32_t)value);
    qs_store_u32(p + 4, (uint32_t)(value >> 32));
}

/* A size that was computed in 64 bits. SIZE_MAX = it does not fit; no workspace is as large. */
static inline size_t qs_size(uint64_t size)
{
    return size < SIZE_MAX ? (size_t)size : SIZE_MAX;
}

/* How many bytes an unsigned integer needs: 1, 2, 4 or 8. */
static inline unsigned qs_bytes_of(uint64_t value)
{
    if (value <= UINT8_MAX) {
        return 1;
    }
    if (value <= UINT16_MAX) {
        return 2;
    }
    return value <= UINT32_MAX ? 4 : 8;
}

#endif
