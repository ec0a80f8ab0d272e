#include "in_64_bits.h"
#include "trws_split.c"
