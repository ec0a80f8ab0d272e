/* Loops over labels that the compiler vectorises: written once, compiled plain and, on x86-64, for
 * AVX2 too. Integers, so both agree to the bit. */
#ifndef QS_SIMD_H
#define QS_SIMD_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__)
#define QS_KERNEL static inline __attribute__((always_inline))
#else
#define QS_KERNEL static inline
#endif

#if defined(__GNUC__) && defined(__x86_64__)

#define QS_HAVE_AVX2 1
#define QS_AVX2      __attribute__((target("avx2")))
#define QS_WIDE      static inline __attribute__((always_inline, target("avx2")))

/* Eight numbers at once; `loose` = as they lie in memory. */
enum { QS_LANES = 8 };
typedef int32_t qs_lanes __attribute__((vector_size(32)));
typedef int32_t qs_four __attribute__((vector_size(16), aligned(4), may_alias));
typedef long long qs_two __attribute__((vector_size(16)));
typedef int32_t qs_loose __attribute__((vector_size(32), aligned(4), may_alias));

#if defined(__clang__)
#define QS_PICK(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define QS_PICK(a, b, ...) __builtin_shuffle(a, b, (qs_lanes){__VA_ARGS__})
#endif

/* Four numbers, twice. */
QS_WIDE qs_lanes qs_lanes_twice(const int32_t *from)
{
#if defined(__clang__)
    qs_four four = *(const qs_four *)from;
    return __builtin_shufflevector(four, four, 0, 1, 2, 3, 0, 1, 2, 3);
#else
    return (qs_lanes)__builtin_ia32_vbroadcastsi256((qs_two) * (const qs_four *)from);
#endif
}

QS_WIDE qs_lanes qs_lanes_all(int32_t value)
{
    return (qs_lanes){value, value, value, value, value, value, value, value};
}

QS_WIDE qs_lanes qs_lanes_min(qs_lanes a, qs_lanes b)
{
#if defined(__clang__)
    return __builtin_elementwise_min(a, b);
#else
    return __builtin_ia32_pminsd256(a, b);
#endif
}

/* The least of each of two, in all lanes of it: both at the price of one. */
QS_WIDE void qs_lanes_least(qs_lanes *a, qs_lanes *b)
{
    qs_lanes both = qs_lanes_min(QS_PICK(*a, *b, 0, 1, 2, 3, 8, 9, 10, 11),
                                 QS_PICK(*a, *b, 4, 5, 6, 7, 12, 13, 14, 15));
    both = qs_lanes_min(both, QS_PICK(both, both, 2, 3, 0, 1, 6, 7, 4, 5));
    both = qs_lanes_min(both, QS_PICK(both, both, 1, 0, 3, 2, 5, 4, 7, 6));
    *a = QS_PICK(both, both, 0, 1, 2, 3, 0, 1, 2, 3);
    *b = QS_PICK(both, both, 4, 5, 6, 7, 4, 5, 6, 7);
}

/* Costs of any number of labels, at least 8, in runs of lanes. A last run of four labels has each
 * twice; any other that is not whole ends at the last label and has some of the run before again:
 * in memory that is slow to read soon after it was written. */
QS_WIDE uint32_t qs_lanes_runs(uint32_t labels)
{
    return (labels + QS_LANES - 1) / QS_LANES;
}

QS_WIDE bool qs_lanes_is_half(uint32_t run, uint32_t labels)
{
    return run * QS_LANES + QS_LANES / 2 == labels;
}

QS_WIDE uint32_t qs_lanes_begin(uint32_t run, uint32_t labels)
{
    return (run + 1) * QS_LANES <= labels || qs_lanes_is_half(run, labels) ? run * QS_LANES
                                                                           : labels - QS_LANES;
}

QS_WIDE qs_lanes qs_lanes_load(const int32_t *costs, uint32_t run, uint32_t labels)
{
    const int32_t *from = costs + qs_lanes_begin(run, labels);
    return qs_lanes_is_half(run, labels) ? qs_lanes_twice(from)
                                         : (qs_lanes) * (const qs_loose *)from;
}

QS_WIDE void qs_lanes_store(int32_t *costs, uint32_t run, uint32_t labels, qs_lanes value)
{
    int32_t *to = costs + qs_lanes_begin(run, labels);
    if (qs_lanes_is_half(run, labels)) {
        memcpy(to, &value, sizeof value / 2);
    } else {
        *(qs_loose *)to = value;
    }
}

/* Has memory fetched that is needed in a while: the processor's own foresight ends at each page. */
QS_WIDE void qs_lanes_fetch(const int32_t *from, uint32_t count)
{
    enum { LINE = 16 };
    for (uint32_t i = 0; i < count; i += LINE) {
        __builtin_prefetch(from + i);
    }
}

/* The first of the labels with the least cost; `least` = the least of each lane. */
QS_WIDE uint16_t qs_lanes_first(const qs_loose *costs, uint32_t labels, qs_lanes least)
{
    enum { OTHERS = 1 << 30 };
    qs_lanes none = qs_lanes_all(INT32_MAX), order = {0, 1, 2, 3, 4, 5, 6, 7}, first = none;
    qs_lanes_least(&least, &none);
    for (uint32_t run = 0; run < qs_lanes_runs(labels); run++) {
        int32_t wrap = qs_lanes_is_half(run, labels) ? QS_LANES / 2 - 1 : QS_LANES - 1;
        qs_lanes label = (order & wrap) + (int32_t)qs_lanes_begin(run, labels);
        first =
            qs_lanes_min(first, label | ((qs_lanes)(costs[run] != least) &
                                         OTHERS)); /* those that cost more come after all labels */
    }
    qs_lanes_least(&first, &none);
    return (uint16_t)first[0];
}

#else
#define QS_HAVE_AVX2 0
#define QS_AVX2
#endif

/* Returns true if this processor and its system have AVX2. */
bool qs_lanes_avx2(void);

#endif
