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

/* What the solver takes for the first rows of a grid; 0 where they have no site. */
static int measure_rows(const made_problem *whole, const solver *by, uint32_t rows,
                        const budget *limit, uint64_t *bytes)
{
    qs_problem part = whole->problem;
    laid_out laid;
    part.grid.height = rows;
    *bytes = 0;
    if (qs_problem_sites(&part) == 0) {
        return DONE;
    }
    budget aside = budget_inside(limit);
    int status = lay_out_problem(whole->name, &part, whole->mend, &aside, &laid);
    *bytes = status == DONE ? solve_bytes(&laid, by, 0) : 0;
    budget_free(&aside);
    return status;
}

/* Half of the rows that are laid out to foresee the work. They are many, because some workspaces
 * grow by another measure once they are large, but they are laid out in no time. */
static uint32_t few_rows(const qs_problem *problem, const budget *limit)
{
    enum { LEAST = 8, VARIABLES = 1 << 21, BYTES = 64 };
    uint64_t most = limit->left / BYTES; /* of one, with room to spare */
    uint64_t row = (uint64_t)problem->grid.width * problem->labels, half = problem->grid.height / 2;
    uint64_t few = (most < VARIABLES ? most : VARIABLES) / (row > 0 ? row : 1);
    few = few < LEAST ? LEAST : few;
    return (uint32_t)(few < half ? few : half);
}

/* What the solver takes for all rows, from what it takes for a few; 0 if that does not say it. Of a
 * graph nothing is known before it is laid out. */
static int foresee_work(const made_problem *whole, const solver *by, const budget *limit,
                        uint64_t *bytes)
{
    const qs_grid *grid = &whole->problem.grid;
    uint32_t rows = few_rows(&whole->problem, limit);
    uint64_t few, more;
    *bytes = 0;
    if (grid->width == 0 || rows == 0) {
        return DONE;
    }
    TRY(measure_rows(whole, by, rows, limit, &few));
    TRY(measure_rows(whole, by, 2 * rows, limit, &more));
    if (few > 0 && more > few) {
        *bytes = bytes_sum(few, bytes_product(more - few, grid->height - rows) / rows);
    }
    return DONE;
}

static uint64_t larger(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

int made_need(const made_problem *whole, const solver *by, uint64_t output, const budget *limit)
{
    uint64_t work;
    if (by->run_straight != NULL) {
        return DONE; /* what it needs is known without a model */
    }
    TRY(foresee_work(whole, by, limit, &work));
    uint64_t all = bytes_sum(qs_model_of_problem_workspace(&whole->problem), larger(work, output));
    bool is_far_over = all - all / 10 > limit->left;
    return is_far_over ? budget_need(limit, whole->name, all) : DONE;
}

int laid_out_need(const laid_out *problem, const solver *by, uint64_t iterations, uint64_t output,
                  const budget *limit)
{
    return budget_need(limit, problem->name, larger(solve_bytes(problem, by, iterations), output));
}

int made_lay_out(const made_problem *whole, bool straight, budget *limit, laid_out *laid)
{
    return straight ? lay_out_straight(whole->name, &whole->problem, laid)
                    : lay_out_problem(whole->name, &whole->problem, whole->mend, limit, laid);
}

int made_solve(const made_problem *solved_one, const solver *by, const search *how, budget *limit,
               laid_out *laid, solved *found)
{
    TRY(made_need(solved_one, by, 0, limit));
    TRY(made_lay_out(solved_one, false, limit, laid));
    TRY(laid_out_need(laid, by, how->iterations, 0, limit));
    TRY(solve_problem(laid, by, how, limit, found));
    return solved_check(laid, by, found);
}
