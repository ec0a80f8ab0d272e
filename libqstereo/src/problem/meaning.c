#include "../../include/qstereo/meaning.h"

enum { STEP_MAX = 65535, PLACE_MAX = 1 << 24 };

static bool is_step(uint32_t value)
{
    return value >= 1 && value <= STEP_MAX;
}

static bool is_place(int32_t value)
{
    return value >= -PLACE_MAX && value <= PLACE_MAX;
}

bool qs_meaning_is_valid(const qs_meaning *meaning)
{
    bool moves = meaning->kind == QS_MEANS_DISPLACEMENT;
    bool steps = moves || meaning->kind == QS_MEANS_GREY;
    bool parts = meaning->kind == QS_MEANS_DISPARITY && meaning->unit != 1;
    bool placed = is_step(meaning->columns) && is_step(meaning->unit) && is_place(meaning->x) &&
                  is_place(meaning->y);
    bool none = meaning->columns == 0 && meaning->x == 0 && meaning->y == 0 &&
                (parts ? meaning->unit <= STEP_MAX : meaning->unit == 0);
    return (unsigned)meaning->kind < QS_MEANING_KINDS &&
           (steps ? is_step(meaning->step) : meaning->step == 0) && (moves ? placed : none);
}
