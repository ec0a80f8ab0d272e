#include "in_64_bits.h"
#include "trws_graph.c"
