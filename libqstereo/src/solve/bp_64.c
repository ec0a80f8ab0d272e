#include "in_64_bits.h"
#include "bp.c"
