#include "crc32c.h"

#include <stdbool.h>

#include "../base/bytes.h"
#include "crc32c_table.h"

static uint32_t by_byte(uint32_t state, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        state = state >> 8 ^ qs_crc32c_table[0][(state ^ bytes[i]) & 0xff];
    }
    return state;
}

uint32_t qs_crc32c_portable(uint32_t crc, const uint8_t *bytes, size_t size)
{
    uint32_t state = ~crc;
#ifndef QS_SMALL
    for (; size >= 8; size -= 8, bytes += 8) {
        uint32_t low = qs_load_u32(bytes) ^ state, high = qs_load_u32(bytes + 4);
        state = 0;
        for (unsigned i = 0; i < 4; i++) {
            state ^= qs_crc32c_table[7 - i][low >> 8 * i & 0xff] ^
                     qs_crc32c_table[3 - i][high >> 8 * i & 0xff];
        }
    }
#endif
    return ~by_byte(state, bytes, size);
}

#if defined(__GNUC__) && defined(__x86_64__) && !defined(QS_SMALL)

#include <cpuid.h>

/* The CRC instruction takes three cycles, but a new one can start in each cycle. So three runs of
 * STEP bytes are computed side by side. Then the states of the first two are moved on by the n
 * bytes of the runs behind them: by a carry-less product with x^(8 n - 33) mod P, which the
 * instruction itself reduces (Gopal et al., Fast CRC Computation for iSCSI Polynomial, Intel
 * 2011). */
enum { STEP = 256 };
static const uint32_t over_one_step = 0xb9e02b86, over_two_steps = 0xdd7e3b0c;

typedef long long vector __attribute__((vector_size(16)));

__attribute__((target("sse4.2,pclmul"))) static uint64_t moved(uint64_t state, uint32_t power)
{
    vector a = {(long long)state, 0}, b = {(long long)power, 0};
    return __builtin_ia32_crc32di(0, (unsigned long long)__builtin_ia32_pclmulqdq128(a, b, 0)[0]);
}

__attribute__((target("sse4.2,pclmul"))) static uint32_t
by_instruction(uint32_t crc, const uint8_t *bytes, size_t size)
{
    uint64_t state = ~crc & UINT32_MAX;
    for (; size >= 3 * STEP; size -= 3 * STEP, bytes += 3 * STEP) {
        uint64_t second = 0, third = 0;
        for (size_t i = 0; i < STEP; i += 8) {
            state = __builtin_ia32_crc32di(state, qs_load_u64(bytes + i));
            second = __builtin_ia32_crc32di(second, qs_load_u64(bytes + STEP + i));
            third = __builtin_ia32_crc32di(third, qs_load_u64(bytes + 2 * STEP + i));
        }
        state = moved(state, over_two_steps) ^ moved(second, over_one_step) ^ third;
    }
    for (; size >= 8; size -= 8, bytes += 8) {
        state = __builtin_ia32_crc32di(state, qs_load_u64(bytes));
    }
    return ~by_byte((uint32_t)state, bytes, size);
}

qs_crc *qs_crc32c_fastest(void)
{
    unsigned a, b, c, d;
    bool has = __get_cpuid(1, &a, &b, &c, &d) && c & bit_SSE4_2 && c & bit_PCLMUL;
    return has ? by_instruction : qs_crc32c_portable;
}

#else

qs_crc *qs_crc32c_fastest(void)
{
    return qs_crc32c_portable;
}

#endif
