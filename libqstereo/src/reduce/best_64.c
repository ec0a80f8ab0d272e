#include "../solve/in_64_bits.h"
#include "best.c"
