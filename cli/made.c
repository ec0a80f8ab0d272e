#include "made.h"

#include "text/fail.h"

static int fail_overflow(const char *name, uint32_t scale, const char *mend)
{
    return fail(BAD_INPUT, name,
                "the coefficients overflow (their sum is above 2^53): %schoose a smaller %s",
                fewer_decimals(mend, scale), mend);
}

int made_fail(const made_problem *failed, const char *fewer, qs_status status)
{
    if (status == QS_E_LIMIT) {
        return fail(BAD_INPUT, failed->name, "sites x labels is more than %u variables: %s",
                    QS_VARIABLES_MAX, fewer);
    }
    if (status == QS_E_OVERFLOW) {
        return fail_overflow(failed->name, failed->problem.scale, failed->mend);
    }
    return fail_status(failed->name, status);
}

int made_encode(const made_problem *encoded, const qs_encode_options *options, const char *mend,
                budget *limit, const qs_sink *sink, uint64_t *size)
{
    size_t workspace_size = qs_encode_workspace(&encoded->problem);
    void *workspace = budget_take(limit, encoded->name, workspace_size);
    if (workspace == NULL) {
        return NO_RESOURCE;
    }
    qs_status written =
        qs_encode(&encoded->problem, options, sink, workspace, workspace_size, size);
    if (written == QS_E_OVERFLOW) {
        return fail_overflow(encoded->name, encoded->problem.scale, mend);
    }
    return written == QS_OK || written == QS_E_IO ? DONE : fail_status(encoded->name, written);
}

int made_solve(const made_problem *solved_one, const solver *by, const search *how, budget *limit,
               laid_out *laid, solved *found)
{
    TRY(lay_out_problem(solved_one->name, &solved_one->problem, solved_one->mend, limit, laid));
    TRY(solve_problem(laid, by, how, limit, found));
    return solved_check(laid, found);
}
