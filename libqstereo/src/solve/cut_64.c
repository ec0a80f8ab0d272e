#include "in_64_bits.h"
#include "cut.c"
