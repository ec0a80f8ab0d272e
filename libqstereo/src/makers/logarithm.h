/* Logarithm and exponential in integers, for costs that come from probabilities. */
#ifndef QS_LOGARITHM_H
#define QS_LOGARITHM_H

#include <stdint.h>

/* log2(value) in units of 2^-16, rounded down; value at least 1. */
uint32_t qs_log2(uint64_t value);

/* ln 2 in units of 2^-32. */
#define QS_LN_2 UINT64_C(2977044472)

/* exp(-i / 32) in units of 2^-30, wrong by 4 at most, for i = 0 .. QS_EXP_STEPS - 1; beyond, it is
 * 0 to that precision. */
enum { QS_EXP_STEPS = 672 };
void qs_exp_table(uint32_t table[QS_EXP_STEPS]);

#endif
