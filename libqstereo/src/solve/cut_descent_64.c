#include "in_64_bits.h"
#include "cut_descent.c"
