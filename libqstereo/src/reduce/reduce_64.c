#include "../solve/in_64_bits.h"
#include "reduce.c"
