#include "in_64_bits.h"
#include "trees.c"
