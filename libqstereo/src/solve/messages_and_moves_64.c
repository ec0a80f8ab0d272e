#include "in_64_bits.h"
#include "messages_and_moves.c"
