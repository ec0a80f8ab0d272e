#include "pairwise.h"

int64_t qs_pairwise_cost(const qs_problem *problem, uint32_t a, uint32_t b)
{
    return qs_pairwise_value(&problem->pairwise, problem->labels, a, b);
}
