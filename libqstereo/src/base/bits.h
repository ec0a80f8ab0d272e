/* The packed bits of a sample: x_i is bit i % 8 of byte i / 8. */
#ifndef QS_BITS_H
#define QS_BITS_H

#include <stdbool.h>
#include <stdint.h>

static inline bool qs_bit(const uint8_t *bits, uint32_t at)
{
    return bits[at / 8] >> at % 8 & 1;
}

static inline void qs_bit_set(uint8_t *bits, uint32_t at, bool value)
{
    uint8_t bit = (uint8_t)(1u << at % 8);
    bits[at / 8] = (uint8_t)(value ? bits[at / 8] | bit : bits[at / 8] & ~bit);
}

/* The first bit at 1 from `from` on, before `end`; `end` = there is none. Most bytes of a sample
 * are 0: these are skipped whole. */
static inline uint32_t qs_bit_next(const uint8_t *bits, uint32_t from, uint32_t end)
{
    while (from < end && !qs_bit(bits, from)) {
        from = bits[from / 8] >> from % 8 == 0 ? (from / 8 + 1) * 8 : from + 1;
    }
    return from < end ? from : end;
}

/* The number of bits at 1. */
static inline uint32_t qs_bit_count(const uint8_t *bits, uint32_t from, uint32_t end)
{
    uint32_t count = 0;
    for (uint32_t i = qs_bit_next(bits, from, end); i < end; i = qs_bit_next(bits, i + 1, end)) {
        count++;
    }
    return count;
}

/* The number of bits at 1 of a byte. */
static inline uint32_t qs_byte_count(uint8_t byte)
{
    uint32_t count = 0;
    for (; byte != 0; byte &= (uint8_t)(byte - 1)) {
        count++;
    }
    return count;
}

#endif
