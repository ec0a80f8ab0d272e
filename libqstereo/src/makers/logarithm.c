#include "logarithm.h"

/* Squaring a number between 1 and 2 doubles its logarithm: each time that the square reaches 2 the
 * next binary digit is 1. */
uint32_t qs_log2(uint64_t value)
{
    uint32_t whole = 63;
    while (value >> whole == 0) {
        whole--;
    }
    uint64_t mantissa = whole > 31 ? value >> (whole - 31) : value << (31 - whole); /* 1 = 2^31 */
    uint32_t digits = whole;
    for (int i = 0; i < 16; i++) {
        mantissa = mantissa * mantissa >> 31;
        digits = digits << 1 | (mantissa >> 32 & 1);
        mantissa >>= mantissa >> 32 & 1;
    }
    return digits;
}

void qs_exp_table(uint32_t table[QS_EXP_STEPS])
{
    const uint64_t ratio = UINT64_C(4162825044); /* exp(-1 / 32) in units of 2^-32 */
    uint64_t value = UINT64_C(1) << 62; /* 1 */
    for (int i = 0; i < QS_EXP_STEPS; i++) {
        table[i] = (uint32_t)((value + (UINT64_C(1) << 31)) >> 32);
        value = (value >> 32) * ratio + ((value & UINT32_MAX) * ratio >> 32);
    }
}
