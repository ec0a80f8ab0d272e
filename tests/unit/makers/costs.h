/* The costs of a row of a problem as they are meant: what was subtracted is added again. */
#ifndef COSTS_H
#define COSTS_H

#include "tiny.h"

enum { COSTS_ROW = 65536, COSTS_WIDTH = 512 };

/* Writes width x labels costs, and checks that the least of each cell was subtracted. */
static inline void costs_of_row(const qs_problem *problem, uint32_t row, int64_t *costs)
{
    static uint32_t made[COSTS_ROW];
    int32_t least[COSTS_WIDTH];
    uint32_t labels = problem->labels;
    assert_int_equal(problem->source.bytes, 4);
    assert_true(problem->grid.width <= COSTS_WIDTH && problem->grid.width * labels <= COSTS_ROW);
    problem->source.row(problem->source.context, row, made, least);
    for (uint32_t x = 0; x < problem->grid.width; x++) {
        bool touches = false;
        for (uint32_t d = 0; d < labels; d++) {
            touches = touches || made[x * labels + d] == 0;
            costs[x * labels + d] = (int64_t)made[x * labels + d] + least[x];
        }
        assert_true(touches);
    }
}

#endif
