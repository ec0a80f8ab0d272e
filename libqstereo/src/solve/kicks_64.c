#include "in_64_bits.h"
#include "kicks.c"
