/* The solver `pack`: which problems it can solve. */
#ifndef QS_PACK_H
#define QS_PACK_H

#include "../../include/qstereo/solve.h"

/* Whether qs_pack can be used: two labels, and no edge favours the same label at both ends. */
bool qs_can_pack(const qs_model *model);

#endif
