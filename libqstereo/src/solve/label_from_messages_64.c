#include "in_64_bits.h"
#include "label_from_messages.c"
