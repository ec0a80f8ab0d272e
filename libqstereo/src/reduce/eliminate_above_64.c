#include "../solve/in_64_bits.h"
#include "eliminate_above.c"
