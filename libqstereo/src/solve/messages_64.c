#include "in_64_bits.h"
#include "messages.c"
