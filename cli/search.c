#include "search.h"

#include "messages.h"
#include "numbers.h"

int search_read(const char *const *values, search *asked)
{
    int status = number64_read("--seed", values[SEARCH_SEED], 0, UINT64_MAX, &asked->seed);
    asked->time_limit = 0;
    asked->iterations = 0;
    if (status == DONE && values[SEARCH_TIME_LIMIT] != NULL) {
        status = seconds_read("--time-limit", values[SEARCH_TIME_LIMIT], &asked->time_limit);
    }
    if (status == DONE && values[SEARCH_ITERATIONS] != NULL) {
        status = number64_read("--iterations", values[SEARCH_ITERATIONS], 1, UINT64_MAX,
                               &asked->iterations);
    }
    return status;
}
