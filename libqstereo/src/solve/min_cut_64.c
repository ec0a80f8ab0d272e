#include "in_64_bits.h"
#include "min_cut.c"
