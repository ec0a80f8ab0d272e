#include "simd.h"

#if QS_HAVE_AVX2

#include <cpuid.h>

bool qs_lanes_avx2(void)
{
    enum { SSE_AND_AVX_STATE = 6 };
    unsigned a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & bit_OSXSAVE) == 0 || (c & bit_AVX) == 0) {
        return false;
    }
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (low & SSE_AND_AVX_STATE) == SSE_AND_AVX_STATE &&
           __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}

#else

bool qs_lanes_avx2(void)
{
    return false;
}

#endif
