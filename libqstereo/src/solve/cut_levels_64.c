#include "in_64_bits.h"
#include "cut_levels.c"
