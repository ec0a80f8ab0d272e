#include "../solve/in_64_bits.h"
#include "probes.c"
