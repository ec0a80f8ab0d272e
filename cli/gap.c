#include "gap.h"

#include <math.h>
#include <stdio.h>

#include "decimal.h"

double gap_percent(int64_t energy, int64_t lower_bound)
{
    return energy == lower_bound ? 0
                                 : 100.0 * (double)(energy - lower_bound) / fabs((double)energy);
}

void gap_write(int64_t energy, int64_t lower_bound, uint32_t scale, char text[GAP_SIZE])
{
    char gap[DECIMAL_SIZE];
    decimal_write(energy - lower_bound, scale, gap);
    if (energy != 0) {
        (void)snprintf(text, GAP_SIZE, "%s (%.4f %%)", gap, gap_percent(energy, lower_bound));
    } else {
        (void)snprintf(text, GAP_SIZE, "%s", gap);
    }
}
