#include "in_64_bits.h"
#include "bp_grid.c"
