#include "pairwise.h"

int64_t qs_pairwise_cost(const qs_problem *problem, uint32_t a, uint32_t b)
{
    return qs_pairwise_value(&problem->pairwise, problem->labels, a, b);
}

uint32_t qs_band(const qs_pairwise *pairwise, uint32_t labels)
{
    if (pairwise->smoothness == QS_POTTS) {
        return 1;
    }
    return pairwise->truncation == 0 || pairwise->truncation > labels - 1 ? labels - 1
                                                                          : pairwise->truncation;
}

bool qs_is_linear(const qs_pairwise *pairwise, uint32_t labels)
{
    return pairwise->smoothness == QS_TRUNCATED_LINEAR && qs_band(pairwise, labels) == labels - 1;
}
