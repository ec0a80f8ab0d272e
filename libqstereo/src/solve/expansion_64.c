#include "in_64_bits.h"
#include "expansion.c"
