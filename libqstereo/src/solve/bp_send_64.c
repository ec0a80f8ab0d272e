#include "in_64_bits.h"
#include "bp_send.c"
