#include "in_64_bits.h"
#include "fusion.c"
