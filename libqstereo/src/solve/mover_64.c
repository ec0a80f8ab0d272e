#include "in_64_bits.h"
#include "mover.c"
