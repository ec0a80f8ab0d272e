/* The distance of an energy from a lower bound, for people. */
#ifndef GAP_H
#define GAP_H

#include <stdint.h>

#define GAP_SIZE 96

/* "3 (0.0008 %)": in real units, and as a share of the energy's size where that is not 0. */
void gap_write(int64_t energy, int64_t lower_bound, uint32_t scale, char text[GAP_SIZE]);

/* That share alone, in percent. */
double gap_percent(int64_t energy, int64_t lower_bound);

#endif
