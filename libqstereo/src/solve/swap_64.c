#include "in_64_bits.h"
#include "swap.c"
