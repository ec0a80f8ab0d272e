#include "in_64_bits.h"
#include "trws.c"
