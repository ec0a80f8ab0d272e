#include "in_64_bits.h"
#include "trws_grid_marginal.c"
